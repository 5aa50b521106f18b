# SPDX-License-Identifier: MIT
"""`terazi calibrate --imu`, `--mag` and `--self-test`, as people and scripts meet them."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from host.tests.calibration.imu_bench import PlayedImu, sitting
from host.tests.captures import CaptureMaker
from host.tests.fake_commands import Eeprom
from host.tests.fake_device import FakeDevice
from terazi.calibration.imu.rehearsal import FACES, Board
from terazi.cli import app
from terazi.link.generated.settings import SETTINGS_BY_NAME

COUNTERS = ("is_matrix_known", "turns", "turns_before_deg", "turns_after_deg")


def terazi(*words):
    words = [str(word) for word in words]
    return CliRunner().invoke(app, ["calibrate", *words], env={"COLUMNS": "100"})


def assert_fails(done, code, words):
    """The exit code and one clear line."""
    assert done.exit_code == code, done.output
    assert "Traceback" not in done.output
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    assert words in line


def as_npz(path, record):
    np.savez(path, gyr=record.gyro_b_counts, acc=record.acc_b_counts, sampling_rate=record.rate_hz)
    return path


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return as_npz(tmp_path_factory.mktemp("sittings") / "sides.npz", sitting())


def test_a_recording_tells_the_settings_without_a_board(recording):
    done = terazi("--imu", "--from", recording, "--dry-run", "--json")
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["settings_saved"] is None
    assert set(told["settings"]) <= set(SETTINGS_BY_NAME)
    offset_g = np.array(told["accelerometer"]["offset_counts"]) / 2048
    assert np.abs(offset_g - Board(1, rate_hz=500.0).acc_offset_g).max() < 0.001
    assert told["accelerometer"]["rms_after_g"] < 0.0005 < told["accelerometer"]["rms_before_g"]
    assert len(told["accelerometer"]["positions"]) == 12
    assert set(COUNTERS) <= set(told["gyroscope"])
    for line in ("gravity off, before", "acc.xx_q16=", "Dry run"):
        assert line in done.stderr


def test_what_is_shown_is_what_set_takes(recording):
    done = terazi("--imu", "--from", recording, "--dry-run")
    values = dict(line.split("=") for line in done.stdout.splitlines() if "_q16=" in line)
    assert len(values) == 15
    for name, value in values.items():
        setting = SETTINGS_BY_NAME[name]
        assert setting.minimum <= int(value) <= setting.maximum


def test_a_captures_own_settings_are_what_held_before(tmp_path):
    first = sitting(2)
    done = terazi("--imu", "--from", as_npz(tmp_path / "a.npz", first), "--dry-run", "--json")
    held = json.loads(done.stdout)["settings"]
    maker = CaptureMaker(tmp_path / "b.terazi").hello()
    maker.settings(**{name.replace(".", "_"): value for name, value in held.items()})
    path = maker.imu(PlayedImu(first), len(first)).end()
    told = json.loads(terazi("--imu", "--from", path, "--dry-run", "--json").stdout)
    assert told["accelerometer"]["rms_before_g"] < 0.0005
    assert np.abs(told["gyroscope"]["bias_before_deg_s"]).max() < 0.05
    assert told["settings"]["acc.xx_q16"] == pytest.approx(held["acc.xx_q16"], abs=3)


def test_a_live_board_is_calibrated_without_a_question_and_keeps_it():
    # It begins as it ends, and goes round: how long a port takes to open is no matter.
    eeprom, record = Eeprom(), sitting(3, (*FACES, FACES[0]))
    keys = {name: SETTINGS_BY_NAME[name].key for name in ("acc.xx_q16", "imu.every")}
    with FakeDevice(
        imu=lambda: PlayedImu(record, loops=True, values=lambda: device.chain.values),
        speed=8.0,
        eeprom=eeprom,
    ) as device:
        done = terazi(device.path, "--imu", "--six-only", "--yes", "--json")
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["settings_saved"] == eeprom.sequence == 1
    assert eeprom.values[keys["acc.xx_q16"]] == told["settings"]["acc.xx_q16"] != 0
    assert eeprom.values[keys["imu.every"]] == 5
    assert "z up: taken" in done.stderr


def test_a_failing_self_test_has_its_exit_code_and_its_object():
    trim = (0x21, 0x21, 0x21, 0)  # accelerometer 4, gyroscope 1, each
    with FakeDevice(
        imu=lambda: PlayedImu(sitting(1, FACES[:1]), trim=trim, values=lambda: device.chain.values)
    ) as device:
        done = terazi(device.path, "--self-test", "--json")
    assert_fails(done, 13, "the self-test fails: accelerometer x (-100%)")
    told = json.loads(done.stdout)
    assert told["passes"] is False
    assert len(told["axes"]) == 6


def test_a_rehearsal_tells_what_is_left_of_known_errors():
    done = terazi("--imu", "--rehearse", 2, "--json")
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert [one["seed"] for one in told["boards"]] == [1, 2]
    assert told["worst"]["offset_mg"] < 1
    assert told["worst"]["scale_percent"] < 0.1
    assert told["worst"]["after_mg"] < 0.5 < 50 < told["worst"]["before_mg"]


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--board-free"], 2, "--board-free belongs to --imu"),
        (["--dry-run"], 2, "--dry-run belongs to --imu or --mag"),
        (["--from", "x.npz"], 2, "--from belongs to --imu or --mag"),
        (["--imu", "--board-free", "--six-only"], 2, "wants no faces"),
        (["--imu", "--mass", "0"], 2, "one after the other"),
        (["--self-test", "--dry-run"], 2, "changes nothing"),
        (["--rehearse", "3"], 2, "--rehearse goes with --imu"),
        (["--level", "--imu"], 2, "--level stands for itself"),
        (["--imu"], 2, "nobody is there to ask"),
        (["--imu", "--from", "absent.terazi", "--dry-run"], 9, "absent.terazi"),
        (["--imu", "--from", "{npz}", "--dry-run", "--mag"], 9, "holds no magnetometer"),
    ],
)
def test_what_makes_no_sense_is_one_line(recording, words, code, said):
    assert_fails(terazi(*(word.format(npz=recording) for word in words)), code, said)


def test_a_recording_that_lies_on_five_sides_names_the_sixth(tmp_path):
    path = as_npz(tmp_path / "five.npz", sitting(1, FACES[:5]))
    assert_fails(terazi("--imu", "--from", path, "--dry-run"), 13, "y down is missing")
