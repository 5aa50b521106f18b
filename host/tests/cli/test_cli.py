# SPDX-License-Identifier: MIT
"""The command as people and scripts meet it: a process, its output and its exit code."""

import json
import os
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import time

import pytest

from host.tests.captures import CaptureMaker
from host.tests.fake_device import FakeDevice
from terazi.link import open_link
from terazi.link.generated.messages import FINGERPRINT
from terazi.recorder import Capture, load_recording

TERAZI = [sys.executable, "-m", "terazi"]
TIMEOUT_S = 60


def terazi(*words, **more):
    environment = {key: value for key, value in os.environ.items() if key != "TERAZI_PORT"}
    return subprocess.run(
        [*TERAZI, *map(str, words)],
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        env=environment | more.pop("env", {}),
        **more,
    )


def assert_fails(done, code, words):
    """The exit code, and one clear line: the rest of the error is at most the remedy."""
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    assert words in line


@pytest.fixture
def capture(tmp_path):
    return tmp_path / "one.terazi"


@pytest.fixture
def recorded(capture):
    return CaptureMaker(capture).hello().samples(400).end()


def test_help_shows_an_example_of_every_verb():
    from typer.testing import CliRunner

    from terazi.cli import VERBS, app

    assert "Usage" in terazi().stdout
    for verb in VERBS:
        assert "terazi " + verb in CliRunner().invoke(app, [verb, "--help"]).output


def test_version_is_told_and_an_unknown_verb_is_a_usage_error():
    assert terazi("--version").stdout.startswith("terazi ")
    assert terazi("dance").returncode == 2


def test_ports_lists_for_people_and_for_machines():
    assert terazi("ports").returncode == 0
    assert isinstance(json.loads(terazi("ports", "--json").stdout), list)


def test_info_says_who_is_there():
    with FakeDevice() as device:
        done = terazi("info", device.path)
    assert done.returncode == 0
    for words in ("0.1.0 (build 1234abcd)", f"0x{FINGERPRINT:04X}", "82.00 SPS", "lowpass32"):
        assert words in done.stdout


def test_info_json_is_one_object_and_nothing_else():
    with FakeDevice() as device:
        done = terazi("info", "--json", env={"TERAZI_PORT": device.path})
    told = json.loads(done.stdout)
    assert told["hello"]["protocol_fingerprint"] == FINGERPRINT
    assert told["status"]["converter_state"] == "running"
    assert told["status"]["converter_rate_hz"] == pytest.approx(82.0, abs=1e-3)


def test_log_records_for_the_seconds_asked(capture):
    with FakeDevice() as device:
        done = terazi("log", device.path, "-o", capture, "--seconds", "0.5")
    assert done.returncode == 0, done.stderr
    recording = load_recording(capture)
    assert recording.ended_cleanly
    assert recording.metadata["port"] == device.path
    assert recording.metadata["protocol_fingerprint"] == f"0x{FINGERPRINT:04X}"
    assert f"{len(recording)} samples" in done.stdout
    assert len(capture.with_suffix(".csv").read_text().splitlines()) == len(recording) + 1
    assert capture.with_suffix(".parquet").exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["ctrl-C", "SIGTERM"])
def test_log_ends_cleanly_by_a_signal_with_everything_on_disk(capture, number):
    with FakeDevice() as device:
        running = subprocess.Popen(
            [*TERAZI, "log", device.path, "-o", str(capture)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        wait_for(lambda: capture.with_suffix(".csv").exists() and lines(capture) > 100)
        running.send_signal(number)
        said, complained = running.communicate(timeout=TIMEOUT_S)
    assert running.returncode == 0, complained
    recording = load_recording(capture)
    assert recording.ended_cleanly
    assert len(recording) >= 100
    assert lines(capture) == len(recording) + 1
    assert f"{len(recording)} samples" in said


def lines(capture):
    return len(capture.with_suffix(".csv").read_text().splitlines())


def wait_for(condition):
    end_s = time.monotonic() + TIMEOUT_S
    while not condition():
        assert time.monotonic() < end_s
        time.sleep(0.02)


def test_log_interrupted_before_the_board_answers_leaves_nothing(capture):
    with FakeDevice(speak="nothing") as device:
        running = subprocess.Popen(
            [*TERAZI, "log", device.path, "-o", str(capture)], stderr=subprocess.PIPE, text=True
        )
        wait_for(lambda: device.resets)
        running.send_signal(signal.SIGINT)
        _said, complained = running.communicate(timeout=TIMEOUT_S)
    assert running.returncode == 130
    assert "interrupted" in complained
    assert not list(capture.parent.iterdir())


def test_log_keeps_everything_when_the_port_vanishes(capture):
    with FakeDevice(vanish_after=300) as device:
        done = terazi("log", device.path, "-o", capture)
    assert_fails(done, 5, f"{device.path} vanished")
    recording = load_recording(capture)
    assert len(recording) > 0
    assert recording.samples["conversion"].tolist() == list(range(1, len(recording) + 1))
    assert lines(capture) == len(recording) + 1
    assert f"{len(recording)} samples" in done.stdout


def test_log_goes_on_over_garbage_on_the_line_and_counts_it(capture):
    faults = {"noise_before": frozenset({50}), "corrupt": frozenset({80})}
    with FakeDevice(lose=frozenset({20, 21}), **faults) as device:
        done = terazi("log", device.path, "-o", capture, "--seconds", "0.5")
    assert done.returncode == 0, done.stderr
    recording = load_recording(capture)
    assert recording.frames_lost == 3
    assert recording.frames_bad >= 2
    assert terazi("replay", capture).returncode == 0


def test_log_of_something_else_fails_and_leaves_nothing(capture):
    with FakeDevice(speak="garbage") as device:
        done = terazi("log", device.path, "-o", capture)
    assert_fails(done, 6, device.path)
    assert "terazi flash" in done.stderr
    assert not list(capture.parent.iterdir())


@pytest.mark.parametrize("verb", ["info", "log"])
def test_another_protocol_is_refused_and_both_are_named(capture, verb):
    words = ["log", "-o", capture] if verb == "log" else ["info"]
    with FakeDevice(fingerprint=FINGERPRINT ^ 0x00FF) as device:
        done = terazi(*words, device.path)
    assert_fails(done, 7, f"0x{FINGERPRINT ^ 0x00FF:04X}, this host speaks 0x{FINGERPRINT:04X}")
    assert not capture.exists()


@pytest.mark.parametrize("verb", ["info", "log"])
def test_missing_port_is_named(capture, verb):
    words = ["log", "-o", capture] if verb == "log" else ["info"]
    assert_fails(terazi(*words, "/dev/ttyACM99"), 3, "there is no port /dev/ttyACM99")
    assert not capture.exists()


def test_busy_port_is_named(capture):
    with FakeDevice() as device, open_link(device.path) as link:
        link.hello()
        done = terazi("log", device.path, "-o", capture)
    assert_fails(done, 4, f"{device.path} is in use by another program")
    assert not capture.exists()


def test_log_refuses_to_overwrite_before_it_disturbs_the_board(recorded):
    before = recorded.read_bytes()
    with FakeDevice() as device:
        done = terazi("log", device.path, "-o", recorded)
        assert device.resets == 0
    assert_fails(done, 8, "one.terazi exists already")
    assert "--force" in done.stderr
    assert recorded.read_bytes() == before


def test_log_overwrites_with_force(recorded):
    with FakeDevice() as device:
        done = terazi("log", device.path, "-o", recorded, "--seconds", "0.2", "--force")
    assert done.returncode == 0, done.stderr
    assert load_recording(recorded).metadata["port"] == device.path


def test_log_with_force_keeps_the_older_recording_when_no_board_answers(recorded):
    before = recorded.read_bytes()
    with FakeDevice(speak="nothing") as device:
        assert terazi("log", device.path, "-o", recorded, "--force").returncode == 6
    assert recorded.read_bytes() == before


def test_log_names_a_missing_folder(tmp_path):
    with FakeDevice() as device:
        done = terazi("log", device.path, "-o", tmp_path / "no" / "one.terazi")
    assert_fails(done, 8, "there is no folder")
    assert f"mkdir -p {tmp_path / 'no'}" in done.stderr


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full on this system")
def test_log_on_a_full_disk_says_so():
    with FakeDevice() as device:
        done = terazi("log", device.path, "-o", "/dev/full", "--force")
    assert_fails(done, 8, "cannot write /dev/full: the disk is full")


def test_log_keeps_what_fitted_when_the_disk_fills_up_in_mid_log(capture):
    def small_disk():
        resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, 30_000))

    with FakeDevice() as device:
        # A measurement of coverage could not be written there either.
        unmeasured = {"COVERAGE_PROCESS_CONFIG": ""}
        done = terazi("log", device.path, "-o", capture, preexec_fn=small_disk, env=unmeasured)
    assert_fails(done, 8, "the largest allowed file size is reached")
    recording = load_recording(capture)
    assert len(recording) > 200
    assert recording.samples["conversion"].tolist() == list(range(1, len(recording) + 1))
    assert recording.cut_off_bytes == 0


def test_log_survives_being_killed(capture):
    with FakeDevice() as device:
        running = subprocess.Popen(
            [*TERAZI, "log", device.path, "-o", str(capture)], stderr=subprocess.DEVNULL
        )
        wait_for(lambda: capture.with_suffix(".csv").exists() and lines(capture) > 100)
        running.kill()
        running.wait()
    recording = load_recording(capture)
    assert not recording.ended_cleanly
    assert len(recording) >= 100
    done = terazi("replay", capture)
    assert done.returncode == 0
    assert "cut off" in done.stderr


def test_replay_json_is_one_object_and_nothing_else(recorded):
    done = terazi("replay", recorded, "--json")
    assert done.returncode == 0
    told = json.loads(done.stdout)
    assert told["agrees"]
    assert told["bit_identical"]
    assert {stage["stage"]: stage["compared"] for stage in told["stages"]} == {
        "fir": 400,
        "kalman": 400,
        "mass": 400,
    }


def test_replay_that_disagrees_shows_where_and_exits_with_10(capture):
    def change(index, sample):
        import dataclasses

        wrong = sample.fir_counts + (index == 77)
        return dataclasses.replace(sample, fir_counts=wrong)

    path = CaptureMaker(capture).hello().samples(200, change=change).end()
    done = terazi("replay", path)
    assert_fails(done, 10, "not those of this host's C")
    assert "differ" in done.stdout
    assert "78" in done.stdout  # the conversion
    assert json.loads(terazi("replay", path, "--json").stdout)["agrees"] is False


@pytest.mark.parametrize("verb", ["replay", "report"])
@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "there is no file"),
        (b"", "is empty"),
        (b"a,b,c\n1,2,3\n", "is not a Terazi capture"),
        (b'TERAZI-CAPTURE 1\n{"a', "cut off within its header"),
        (b"TERAZI-CAPTURE 1\n{}\n", "holds no HELLO"),
    ],
    ids=["missing", "empty", "csv", "cut header", "no records"],
)
def test_unusable_captures_are_named(capture, verb, content, words):
    if content is not None:
        capture.write_bytes(content)
    assert_fails(terazi(verb, capture), 9, words)
    assert not capture.with_suffix(".html").exists()


def test_truncated_capture_is_replayed_up_to_the_cut(recorded):
    recorded.write_bytes(recorded.read_bytes()[:-3000])
    kept = len(list(Capture(recorded).chunks()))
    assert 0 < kept < 400
    done = terazi("replay", recorded)
    assert done.returncode == 0
    assert "cut off" in done.stderr


def test_report_is_written_beside_the_capture_or_where_told(recorded, tmp_path):
    truth = tmp_path / "truth.csv"
    truth.write_text("t_s,load_g\n0,0\n2,500\n5,500\n")
    done = terazi("report", recorded)
    assert done.returncode == 0, done.stderr
    assert "<!DOCTYPE html>" in recorded.with_suffix(".html").read_text()
    assert [line.split()[0] for line in done.stdout.splitlines()[1:4]] == ["raw", "fir", "kalman"]
    page = tmp_path / "other.html"
    assert terazi("report", recorded, "--truth", truth, "-o", page).returncode == 0
    assert "error to the truth" in page.read_text()


def test_report_does_not_overwrite_what_it_is_made_of(recorded):
    before = recorded.read_bytes()
    assert_fails(terazi("report", recorded, "-o", recorded), 2, "would overwrite")
    assert recorded.read_bytes() == before


def test_report_names_a_truth_that_is_none(recorded, tmp_path):
    truth = tmp_path / "truth.csv"
    truth.write_text("time,grams\n0,0\n")
    assert_fails(terazi("report", recorded, "--truth", truth), 9, "no column load_g")


def test_output_into_a_closed_pipe_is_no_traceback(recorded):
    shell = f"{shlex.join(TERAZI)} replay {recorded} --json | true"
    done = subprocess.run(
        [shutil.which("sh"), "-c", shell], capture_output=True, text=True, timeout=TIMEOUT_S
    )
    assert "Traceback" not in done.stderr
