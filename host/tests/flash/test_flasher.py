# SPDX-License-Identifier: MIT
"""The order of things when a board is flashed, and where image and log are looked for."""

import io
from pathlib import Path

import pytest
from rich.console import Console

from host.tests.fake_device import FakeDevice
from terazi.cli import flash as cli
from terazi.errors import FingerprintMismatch, FlashFailed, NoAnswer, PortMissing, UsageError
from terazi.link import flasher
from terazi.link.generated.messages import FINGERPRINT, Hello

DONE = (Path(__file__).parent / "said" / "7.1_done.txt").read_text()
HEX = ":0100000001FE\n:00000001FF\n"  # one byte, a one, at address 0


@pytest.fixture
def image(tmp_path) -> Path:
    path = tmp_path / "image.hex"
    path.write_text(HEX)
    return path


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch) -> Path:
    """No clone around, and a home of the test's own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state" / "terazi"


def test_board_is_asked_then_written_then_asked_again(play, image, state):
    play(f"say({DONE!r})")
    stages = []
    with FakeDevice() as device:
        done = flasher.flash(device.path, image, on_stage=lambda *step: stages.append(step))
        assert device.resets == 2
    assert isinstance(done.before, Hello)
    assert isinstance(done.after, Hello)
    assert done.image.data == b"\x01"
    names = list(dict(stages))
    assert names[:2] == ["asking who is there", "waking the boot loader"]
    assert names[2:] == ["writing", "verifying", "waiting for the new firmware"]
    assert done.log.parent == state
    assert done.log.read_text().endswith(DONE)


@pytest.mark.parametrize("baud", [500_000, 1_000_000])
def test_board_is_found_at_the_rate_that_it_was_set_to(play, image, baud):
    play(f"say({DONE!r})")
    with FakeDevice(baud=baud) as device:
        done = flasher.flash(device.path, image)
    assert done.before is None  # asked at the boot loader's rate only
    assert isinstance(done.after, Hello)


def test_board_is_not_asked_again_when_it_could_not_be_written(play, image):
    play("sys.exit(1)")
    with FakeDevice() as device, pytest.raises(FlashFailed):
        flasher.flash(device.path, image)
    assert device.resets == 1


def test_nothing_is_written_where_there_is_no_board(play, image, tmp_path):
    play(f"open({str(tmp_path / 'ran')!r}, 'w')")
    with pytest.raises(PortMissing):
        flasher.flash(str(tmp_path / "none"), image)
    assert not (tmp_path / "ran").exists()


def test_firmware_of_another_protocol_is_no_obstacle():
    with FakeDevice(fingerprint=FINGERPRINT ^ 1) as device:
        other = flasher.who_is_there(device.path)
    assert isinstance(other, FingerprintMismatch)
    assert "firmware 0.1.0" in cli._who(other)


def test_other_sketch_is_no_obstacle_before_and_named_after(monkeypatch):
    monkeypatch.setattr(flasher, "HELLO_AFTER_FLASH_S", 0.2)
    with FakeDevice(speak="other") as device:
        assert flasher.who_is_there(device.path) is None
        with pytest.raises(NoAnswer, match="programmed and verified"):
            flasher.await_firmware(device.path)


def test_image_is_the_one_that_was_built_in_the_clone_around(tmp_path, monkeypatch):
    inner = tmp_path / "clone" / "firmware" / "app"
    inner.mkdir(parents=True)
    (tmp_path / "clone" / "shared_c").mkdir()
    (tmp_path / "clone" / "firmware" / "Makefile").touch()
    monkeypatch.chdir(inner)
    with pytest.raises(UsageError, match="not built"):
        flasher.built_hex()
    built = tmp_path / "clone" / ".build" / "firmware" / "terazi.hex"
    built.parent.mkdir(parents=True)
    built.write_text(HEX)
    assert flasher.built_hex() == built
    assert flasher.log_path("/dev/ttyACM0").parent == tmp_path / "clone" / ".build" / "flash"


def test_image_must_be_named_where_there_is_no_clone():
    with pytest.raises(UsageError, match="which image"):
        flasher.built_hex()


def test_each_port_has_a_log_of_its_own(state):
    assert flasher.log_path("/dev/ttyACM0") == state / "avrdude-dev-ttyACM0.log"
    assert flasher.log_path("COM3") == state / "avrdude-COM3.log"


def test_log_goes_to_the_folder_for_temporary_files_where_the_state_cannot_be_kept(
    tmp_path, monkeypatch
):
    (tmp_path / "state").write_text("a file where a folder should be")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    assert flasher.log_path("COM3") == tmp_path / "temporary" / "avrdude-COM3.log"


def test_terminal_shows_each_stage_with_its_part_done(play, image, monkeypatch):
    play(f"say({DONE!r})")
    monkeypatch.setenv("TERM", "xterm")  # what the tests run in may be called dumb
    screen, said = io.StringIO(), io.StringIO()
    monkeypatch.setattr(cli, "errors", Console(file=screen, force_terminal=True, width=100))
    monkeypatch.setattr(cli, "out", Console(file=said, width=100))
    with FakeDevice() as device:
        cli.flash(device.path, image)
    for stage in ("asking who is there", "waiting for the new firmware"):
        assert stage in screen.getvalue()
    assert said.getvalue().startswith("before  Terazi 0.1.0 (build 1234abcd)\nafter   Terazi 0.1.0")
