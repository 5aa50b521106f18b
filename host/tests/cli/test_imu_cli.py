# SPDX-License-Identifier: MIT
"""info, watch, log and set where the board has an IMU, and where its line has another rate."""

import functools
import itertools
import json
import math
import re

import pytest

from host.tests.cli.test_scale_cli import assert_fails, terazi
from host.tests.fake_commands import Eeprom
from host.tests.fake_device import FakeDevice
from host.tests.fake_imu import FakeImu
from terazi.control.inertial import tilt_words
from terazi.link.generated.messages import ImuState
from terazi.link.generated.settings import SettingKey
from terazi.link.load import baud_for, imu_advice
from terazi.recorder import load_recording

SLOW = functools.partial(FakeImu, rate_hz=100)  # the double is Python: 100 Hz will do


def test_info_tells_of_the_imu_and_how_it_lies():
    with FakeDevice(speed=5.0, imu=SLOW) as device:
        done = terazi("info", device.path)
    assert done.exit_code == 0, done.output
    assert re.search(r"IMU +MPU-6050 \(WHO_AM_I 0x68\) running, 4\.2 °C", done.stdout)
    assert "no magnetometer; mode hz_500, one in 5 samples told" in done.stdout
    assert re.search(r"\d+ samples, none lost", done.stdout)
    assert re.search(r"tilt +\d+\.\d+° off the vertical: ", done.stdout)
    assert "sibling" not in done.stdout


@pytest.mark.parametrize(
    ("tilt_deg", "words"),
    [
        (0.0, "0.00° off the vertical: a scale weighs 0.000 % too little"),
        (2.0, "2.00° off the vertical: a scale weighs 0.061 % too little"),
        (178.0, "178.0° off the vertical: no scale stands so"),
    ],
)
def test_tilt_is_told_with_what_a_scale_makes_of_it(tilt_deg, words):
    assert tilt_words(tilt_deg) == words


def test_info_names_a_sibling_warns_and_goes_on():
    with FakeDevice(speed=5.0, imu=functools.partial(SLOW, identity=0x70, mag_every=10)) as device:
        done = terazi("info", device.path)
    assert done.exit_code == 0, done.output
    assert "magnetometer QMC5883L" in done.stdout
    assert "MPU-6500 (WHO_AM_I 0x70) running" in done.stdout
    words = " ".join(done.stdout.split())
    assert "WHO_AM_I is 0x70, that of an MPU-6500: it is used as an MPU-6050" in words


def test_info_tells_of_an_imu_that_went_and_of_what_was_lost():
    with FakeDevice(
        speed=5.0, imu=functools.partial(SLOW, state=ImuState.ABSENT, missed=7)
    ) as device:
        done = terazi("info", device.path)
    assert re.search(r"IMU +MPU-6050 \(WHO_AM_I 0x68\) absent\s", done.stdout)
    assert "missed 7" in done.stdout
    assert "tilt" not in done.stdout


def test_info_without_an_imu_says_so_to_people_and_machines():
    with FakeDevice() as device:
        assert re.search(r"IMU +none was seen", terazi("info", device.path).stdout)
        assert json.loads(terazi("info", device.path, "--json").stdout)["imu"] is None


def test_info_tells_machines_of_the_imu_in_units():
    with FakeDevice(speed=5.0, imu=SLOW) as device:
        told = json.loads(terazi("info", device.path, "--json").stdout)["imu"]
    assert (told["identity"], told["state"], told["mag_kind"]) == (0x68, "running", "none")
    assert told["temperature_deg_c"] == pytest.approx(4.177)
    assert math.hypot(*(told[f"up_{axis}"] for axis in "xyz")) == pytest.approx(1.0, abs=1e-3)
    assert math.cos(math.radians(told["tilt_deg"])) == pytest.approx(told["up_z"], abs=1e-3)


def test_watch_prints_the_attitude_once_a_second_into_a_pipe():
    with FakeDevice(speed=5.0, imu=SLOW) as device:
        done = terazi("watch", device.path, "--seconds", 1.0)
    assert done.exit_code == 0, done.output
    found = re.findall(r"(\d+\.\d+) s  roll +([+-][\d.]+)°  pitch.*yaw", done.stdout)
    times_ms = [round(1000 * float(at_s)) for at_s, _roll in found]
    assert len(times_ms) >= 3
    assert all(later - former >= 1000 for former, later in itertools.pairwise(times_ms))


def test_log_records_attitudes_always_and_raw_samples_where_asked(tmp_path):
    for name, words in (("plain", []), ("raw", ["--imu"])):
        with FakeDevice(speed=5.0, imu=functools.partial(SLOW, every=1)) as device:
            capture = tmp_path / f"{name}.terazi"
            done = terazi("log", device.path, "-o", capture, "--seconds", 0.3, *words)
        assert done.exit_code == 0, done.output
        inertial = load_recording(capture).inertial
        assert len(inertial.attitude["sample"]) > 10
        assert capture.with_suffix(".attitude.csv").exists()
        assert capture.with_suffix(".imu.csv").exists() == (name == "raw")
        raw = len(inertial.imu["sample"])
        assert (raw > 10) == (name == "raw")
        assert f"{raw} raw samples, {len(inertial.attitude['sample'])} attitudes" in done.stdout


def test_log_of_every_raw_sample_is_replayed_from_a_new_start_of_the_chain(tmp_path):
    capture, eeprom = tmp_path / "a.terazi", Eeprom(values={SettingKey.IMU_EVERY: 1})
    imu = functools.partial(FakeImu, rate_hz=500, every=1)
    with FakeDevice(imu=imu, eeprom=eeprom, speed=2.0) as device:
        done = terazi("log", device.path, "-o", capture, "--seconds", 0.5, "--imu")
        assert done.exit_code == 0, done.output
    done = terazi("replay", capture, "--json")
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    compared = {one["stage"]: one["compared"] for one in told["stages"]}
    assert compared["attitude"] == compared["still"] > 100
    assert re.search(r"attitude +the C +\d+ +bit-identical", terazi("replay", capture).stdout)


def test_log_of_a_board_at_another_rate_holds_its_start(tmp_path):
    with FakeDevice(baud=500_000, speed=5.0) as device:
        done = terazi("log", device.path, "-o", tmp_path / "a.terazi", "--seconds", 0.3)
        assert done.exit_code == 0, done.output
        assert device.resets == 2
    recording = load_recording(tmp_path / "a.terazi")
    assert recording.metadata["baud"] == 500_000
    assert recording.samples["conversion"][0] == 1
    assert (recording.frames_lost, recording.frames_bad) == (0, 0)


def test_log_says_what_a_replay_of_the_attitude_will_miss(tmp_path):
    with FakeDevice(speed=5.0, imu=SLOW, baud=115_200) as device:
        done = terazi("log", device.path, "-o", tmp_path / "a.terazi", "--imu", "--seconds", 0.1)
    assert "One in 5 samples is recorded; a replay of the attitude needs all" in done.stderr
    assert "more than 115200 baud" not in done.stderr
    assert load_recording(tmp_path / "a.terazi").metadata["baud"] == 115_200


@pytest.mark.parametrize(
    ("rate_hz", "every", "baud"),
    [(500, 5, 115_200), (500, 1, 500_000), (1000, 5, 500_000), (1000, 1, 1_000_000)],
)
def test_line_that_raw_samples_need(rate_hz, every, baud):
    assert baud_for(rate_hz, every) == baud


def test_advice_for_raw_samples_names_what_to_change():
    settings = {"imu.mode": 2, "imu.every": 1}
    (advice,) = imu_advice(settings, 500_000)
    assert "at 1000 Hz is more than 500000 baud can carry" in advice
    assert "terazi set uart.baud=1000000" in advice
    assert imu_advice(settings, 1_000_000) == []
    (advice,) = imu_advice(settings | {"imu.mode": 0}, 1_000_000)
    assert "terazi set imu.mode=hz_500" in advice


@pytest.mark.parametrize("text", ["500000", "b500000"])
def test_set_baud_saves_restarts_and_finds_the_board_again(text):
    eeprom = Eeprom()
    with FakeDevice(baud=115_200, eeprom=eeprom) as device:
        done = terazi("set", device.path, f"uart.baud={text}")
        assert done.exit_code == 0, done.output
        assert "uart.baud  b115200 -> b500000" in done.stdout
        assert "restarted: it speaks 500000 baud now" in done.stdout
        assert device.baud == 500_000
        assert device.resets == 2
        done = terazi("set", device.path, "uart.baud=115200", "--json")
        assert json.loads(done.stdout) == {"uart.baud": {"before": 1, "now": 0}}
    assert eeprom.values[SettingKey.UART_BAUD] == 0


def test_set_baud_that_holds_already_restarts_nothing():
    with FakeDevice(baud=115_200) as device:
        done = terazi("set", device.path, "uart.baud=115200")
        assert "as it was" in done.stdout
        assert device.resets == 1


def test_reset_of_settings_follows_the_board_to_its_first_rate():
    eeprom = Eeprom(values={SettingKey.UART_BAUD: 2})
    with FakeDevice(baud=1_000_000, eeprom=eeprom) as device:
        done = terazi("set", device.path, "--reset")
        assert "it speaks 115200 baud now" in done.stdout, done.output


def test_set_baud_without_saving_is_refused_before_the_board_is_disturbed():
    with FakeDevice() as device:
        done = terazi("set", device.path, "uart.baud=500000", "--no-save")
        assert_fails(done, 2, "uart.baud holds from the next start on")
        assert device.resets == 0


def test_set_names_the_orientations():
    with FakeDevice() as device:
        assert_fails(terazi("set", device.path, "imu.orientation=pz"), 2, "imu.orientation cannot")
        done = terazi("set", device.path, "imu.orientation=nx_py")
        assert "imu.orientation  px_py -> nx_py" in done.stdout


def test_list_of_settings_leaves_out_calibrations_that_nobody_made():
    with FakeDevice() as device:
        done = terazi("set", device.path, "--list")
        assert "imu.mode" in done.stdout
        assert "gyro.xy_q16" not in done.stdout
        done = terazi("set", device.path, "gyro.offset_q3_1=12")
        assert done.exit_code == 0, done.output
        done = terazi("set", device.path, "--list")
        assert "gyro.xy_q16" in done.stdout
        assert "acc.xx_q16" not in done.stdout
