# SPDX-License-Identifier: MIT
"""avrdude's words (said/) become one clear error, and its bars progress; a scripted avrdude plays
what no board can be made to do at will. What a board can do is in hil_tests/flash.
"""

import itertools
import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.errors import (
    CannotWrite,
    FlashFailed,
    PortBusy,
    PortMissing,
    PortVanished,
    UsageError,
)
from terazi.link import avrdude
from terazi.link.avrdude import Progress, Run, diagnose, find_avrdude, write_flash

BAUD = 115_200
SAID = {path.stem: path.read_text() for path in (Path(__file__).parent / "said").glob("*.txt")}
BEGUN = SAID["7.1_done"].split("#")[0]  # up to the first mark of the bar for writing
MARK = "#"


@pytest.fixture
def port(tmp_path) -> str:
    """Something that exists where a port would be."""
    path = tmp_path / "port"
    path.touch()
    return str(path)


def failed(said: str, port: str) -> Run:
    progress = Progress()
    progress.feed(said.encode())
    return Run(1, said.replace("PORT", port), progress.stage, progress.done)


FAILURES = {
    "7.1_wrong_baud": (FlashFailed, "no boot loader answers"),
    "6.3_no_boot_loader": (FlashFailed, "115200 baud"),
    "7.1_wrong_part": (FlashFailed, "0x1E9801 (probably m2560)"),
    "6.3_wrong_part": (FlashFailed, "0x1E9514 (probably m328)"),
    "8.0_wrong_part": (FlashFailed, "0x1E9516 (ATmega328PB)"),
    "7.1_busy": (PortBusy, "in use by another program"),
    "7.1_not_allowed": (PortBusy, "permission denied"),
    "7.1_mismatch": (FlashFailed, "read back"),
    "7.1_no_hex": (FlashFailed, "read from file"),
    "7.1_silent_midway": (FlashFailed, "writing, at 48%"),
    "6.3_broke_off": (PortVanished, "writing, at 10%"),
}


@pytest.mark.parametrize("name", FAILURES)
def test_failure_is_named(name, port):
    error, clue = FAILURES[name]
    named = diagnose(failed(SAID[name], port), port, BAUD)
    assert type(named) is error
    assert clue in str(named)
    assert port in str(named)
    assert "\n" not in str(named)


def test_failure_without_a_word_is_a_boot_loader_that_does_not_answer(port):
    assert "no boot loader answers" in str(diagnose(failed("", port), port, BAUD))


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("7.1_no_port", PortMissing),
        ("6.3_no_port", PortMissing),
        ("7.1_silent_midway", PortVanished),
        ("6.3_no_boot_loader", PortVanished),
    ],
)
def test_port_that_is_gone_is_named_so_whatever_avrdude_says(name, error, tmp_path):
    gone = str(tmp_path / "none")
    assert type(diagnose(failed(SAID[name], gone), gone, BAUD)) is error


@pytest.mark.parametrize("name", ["7.1_done", "6.3_done"])
def test_right_signature_is_no_fault(name):
    assert avrdude._wrong_signature(SAID[name]) is None


@pytest.mark.parametrize("name", ["7.1_done", "6.3_done"])
@given(cuts=st.lists(st.integers(0, 1200), max_size=40))
def test_progress_rises_from_writing_to_verified_however_the_output_is_cut(name, cuts):
    said = SAID[name].encode()
    seen = []
    progress = Progress(lambda stage, done: seen.append((stage, done)))
    edges = [0, *sorted(cuts), len(said)]
    for begin, end in itertools.pairwise(edges):
        progress.feed(said[begin:end])
    stages = [stage for stage, _done in seen]
    assert stages == sorted(stages, key=["writing", "verifying"].index)
    for stage in ("writing", "verifying"):
        done = [part for name, part in seen if name == stage]
        assert done == sorted(done)
        assert (done[0], done[-1]) == (0.0, 1.0)


@given(noise=st.binary(max_size=300))
def test_any_output_gives_progress_between_0_and_1_and_some_error(noise):
    progress = Progress()
    progress.feed(noise)
    assert 0.0 <= progress.done <= 1.0
    run = Run(1, noise.decode("utf-8", "replace"), progress.stage, progress.done)
    assert str(diagnose(run, os.devnull, BAUD))


def write(port: str, tmp_path: Path, on_progress=None) -> Path:
    log = tmp_path / "avrdude.log"
    write_flash(port, tmp_path / "terazi.hex", baud=BAUD, log=log, on_progress=on_progress)
    return log


def test_run_that_verifies_is_good_and_leaves_its_log(play, port, tmp_path):
    play(f"say({SAID['7.1_done']!r})")
    seen = []
    log = write(port, tmp_path, lambda stage, done: seen.append((stage, done)))
    assert seen[0] == ("writing", 0.0)
    assert seen[-1] == ("verifying", 1.0)
    first, rest = log.read_text().split("\n", 1)
    assert rest == SAID["7.1_done"]
    assert first.endswith(f"-P {port} -b 115200 -D -U flash:w:{tmp_path / 'terazi.hex'}:i")


def test_exit_code_0_without_a_word_of_verifying_is_no_success(play, port, tmp_path):
    play("say('avrdude done.  Thank you.')")
    with pytest.raises(FlashFailed):
        write(port, tmp_path)


def test_failure_names_the_log(play, port, tmp_path):
    play(f"say({SAID['7.1_wrong_part']!r}); sys.exit(1)")
    with pytest.raises(FlashFailed, match="no ATmega328P") as error:
        write(port, tmp_path)
    assert str(tmp_path / "avrdude.log") in error.value.remedy


def test_avrdude_that_reads_for_ever_from_a_pulled_cable_is_ended(play, port, tmp_path):
    # As avrdude 7.1 does: it never notices, and never ends.
    play(f"say({BEGUN + 25 * MARK!r}); os.remove(port); time.sleep(3600)")
    with pytest.raises(PortVanished, match=r"went away while being flashed \(writing, at 50%\)"):
        write(port, tmp_path)


@pytest.mark.parametrize("word", ["", "avrdude error: programmer is not responding\n"])
def test_avrdude_that_gets_no_further_is_ended(word, play, port, tmp_path, monkeypatch):
    # As avrdude 7.1 does at a board that fell silent: the same complaint, for many minutes.
    program = f"say({BEGUN + 10 * MARK + chr(10)!r})\nwhile True: say({word!r}); time.sleep(0.02)"
    play(program)

    def lose_patience(_stage, done):  # and not while the program is still being started
        if done >= 0.2:
            monkeypatch.setattr(avrdude, "PATIENCE_S", 0.5)

    with pytest.raises(FlashFailed, match=r"stopped answering .*\(writing, at 20%\)"):
        write(port, tmp_path, lose_patience)


def test_no_avrdude_is_named_with_the_way_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(UsageError, match="avrdude is not installed") as error:
        find_avrdude()
    assert error.value.exit_code == 2
    assert "apt install avrdude" in error.value.remedy


def test_log_that_cannot_be_written_is_named(play, port, tmp_path):
    play("say('never run')")
    log = tmp_path / "none" / "avrdude.log"
    with pytest.raises(CannotWrite, match=r"avrdude\.log"):
        write_flash(port, tmp_path / "terazi.hex", baud=BAUD, log=log)
