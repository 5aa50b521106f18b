# SPDX-License-Identifier: MIT
"""Attitude beside the scale: the very bits of the host's C, from any start, through any fault."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from terazi.applications.attitude import estimate, find_trials, load_trial, score
from terazi.applications.attitude.score import attitude_errors
from terazi.control.settings import read_settings
from terazi.errors import CommandRefused
from terazi.link.generated.messages import (
    Attitude,
    AttitudeFlag,
    Fault,
    FaultFlag,
    ImuStatus,
    Sample,
    SaveSettings,
    SetSetting,
    SetStream,
    Setting,
    SettingsState,
    StreamFlag,
    Weight,
    WeightFlag,
)
from terazi.link.generated.settings import SETTINGS_BY_NAME, SettingKey
from terazi.recorder import Recorder
from terazi.recorder.inertial import quats_of
from terazi.recorder.recording import load_recording
from terazi.replay.attitude_compare import compare_attitude
from terazi.rotation import euler_deg, unit, up_b
from virtual_uno.motion import read_motion

COUNTS_PER_GRAM = 429.55
RAW = int(StreamFlag.IMU | StreamFlag.ATTITUDE | StreamFlag.STATUS)
BOOT_US = 2_000  # by which the device's clock starts late
BAUD = 1_000_000
SEEN_US = 20_000  # a fault is told within
TRIAL_S, PART_DELAY_S = 40.0, 2.8e-3  # DLPF 2
BACK_US = 500_000  # and attitude is back within
ASIDE = (0.6, -0.64, 0.48)
PORTB, LED = 0x25, 1 << 5
DOWN = (0.0, 0.0, -1.0)


def put(uno, key, value):
    assert uno.link.ask(SetSetting(key, value), Setting, key=key).value == value


def keep(uno, **settings):
    """Settings by their keys' names, in force from the next start on."""
    uno.link.command(SetStream(mask=int(StreamFlag.STATUS)))  # whatever the rates, answers come
    for name, value in settings.items():
        put(uno, SettingKey[name.upper()], value)
    uno.link.command(SaveSettings())
    while uno.link.status().settings_state == SettingsState.WRITING:
        uno.wait(0.1)
    uno.reset()


def fitted(uno, motion="still", **felt):
    """An IMU that feels this, from the start of the board on."""
    virtual = uno.truth("turn itself")
    path = read_motion(motion)
    virtual.imu.fit().noise()
    virtual.imu.feel(**{"acc_g": path.acc_g, "gyro_deg_s": path.gyro_deg_s} | felt)
    return virtual


def attitudes(received):
    return [one for one in received if isinstance(one.message, Attitude)]


def quats(received):
    parts = ("quat_w_q30", "quat_x_q30", "quat_y_q30", "quat_z_q30")
    return np.array([[getattr(one.message, part) for part in parts] for one in received], float)


def angle_deg(one, other):
    """Between directions, rows of three."""
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(one, other), axis=-1), one @ other))


def newest(received, kind):
    return next(one.message for one in reversed(received) if isinstance(one.message, kind))


# --- the start ---


@pytest.mark.parametrize(
    "up", [(0, 0, 1), DOWN, (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), ASIDE, (1e-3, 0, -1)]
)
def test_from_any_attitude_it_is_right_within_half_a_second_of_rest(uno, up):
    up = np.array(up, float) / np.linalg.norm(up)
    fitted(uno, acc_g=tuple(up), gyro_deg_s=(2.0, -1.5, 1.0))
    uno.link.hello()
    first, *_rest = found = attitudes(uno.wait(1.2))
    late = [one for one in found if one.device_us >= first.device_us + 500_000]
    assert len(late) > 30
    assert angle_deg(up_b(quats(late)), up).max() < 1.0


def test_gyro_bias_is_learnt_at_rest_and_told(uno):
    fitted(uno, gyro_deg_s=(2.0, -1.5, 1.0))
    uno.link.hello()
    received = uno.wait(6.0)
    status = newest(received, ImuStatus)
    bias = np.array([status.bias_x_q16, status.bias_y_q16, status.bias_z_q16]) / 65536 / 16.384
    assert np.abs(bias - [2.0, -1.5, 1.0]).max() < 0.05
    flags = attitudes(received)[-1].message.flags
    assert flags & AttitudeFlag.REST
    assert flags & AttitudeFlag.BIAS_KNOWN
    assert flags & AttitudeFlag.STILL


# --- the chain ---


def record(uno, path, seconds):
    """What comes within so many seconds of a reset, and the settings, as a capture."""
    recorder = Recorder(path)
    uno.link.on_bytes = recorder.on_bytes
    recorder.begin(port="virtual", baud=BAUD, age_s=uno.link.now_s())
    uno.truth("change its rate").uart.host_baud = BAUD
    uno.reset()
    read_settings(uno.link, SETTINGS_BY_NAME)
    for received in uno.wait(seconds):
        recorder.add(received)
    uno.link.on_bytes = None
    recorder.finish(uno.link.stream, uno.link.now_s())
    return load_recording(path, needs_samples=False)


def assert_same_bits(recording):
    stages, unverified = compare_attitude(recording)
    assert not unverified
    assert stages[0].stage == "attitude"
    for stage in stages:
        assert stage.compared > 1000
        assert stage.differing == 0, stage.first


CALIBRATED = {
    "acc_xx_q16": 900, "acc_yx_q16": -700, "acc_zz_q16": -1200, "acc_offset_q3_1": 640,
    "gyro_xy_q16": 500, "gyro_zz_q16": -1500, "gyro_offset_q3_0": 210, "gyro_offset_q3_2": -99,
    "mag_xx_q16": 2000, "mag_yz_q16": -300, "mag_offset_q3_0": 1111, "mag_offset_q3_2": -2222,
}  # fmt: skip
# x along the part's +y and y along its -x; x along -z and y along +y
ASTRIDE = {"imu_orientation": 0b100001, "mag_orientation": 0b001110}


@pytest.mark.parametrize(
    ("mode", "mag", "zupt"),
    [(1, None, 1), (1, "hmc5883l", 1), (2, "qmc5883l", 1), (1, None, 5), (2, None, 5)],
    ids=["500", "500 hmc", "1000 qmc", "500 gru", "1000 gru"],
)
def test_every_attitude_is_the_hosts_bit_for_bit(uno, tmp_path, mode, mag, zupt):
    virtual = fitted(uno, "rocking")
    if mag:
        virtual.mag.fit(mag).feel(read_motion("rocking").field_ut)
    uno.link.hello()
    chosen = {"imu_mode": mode, "imu_zupt": zupt, "imu_every": 1}
    keep(uno, uart_baud=2, stream_mask=RAW, **chosen, **CALIBRATED, **ASTRIDE)
    uno.wait(0.5)
    recording = record(uno, tmp_path / "a.terazi", 4.0)
    assert_same_bits(recording)
    flags = recording.inertial.attitude["flags"]
    assert bool(flags[-1] & AttitudeFlag.HEADING) == bool(mag)
    assert 0 < np.mean(flags & AttitudeFlag.STILL != 0) < 1


def test_heading_comes_from_the_magnetometer_and_north_is_north(uno):
    virtual = fitted(uno, "rocking")
    virtual.mag.fit("qmc5883l").feel(read_motion("rocking").field_ut)
    uno.link.hello()
    found = attitudes(uno.wait(12.0))
    yaw_deg = euler_deg(quats(found))[:, 2]
    truth_deg = [_yaw_deg(one.device_us / 1e6) for one in found]
    late = slice(len(found) // 2, None)
    assert np.abs(yaw_deg - truth_deg)[late].max() < 3.0


def _yaw_deg(t_s):
    return 20.0 * (1 - np.cos(2 * np.pi * 0.05 * max(t_s - 3.0, 0.0)))


@pytest.fixture
def trial():
    """A minute of a recording of an IMU beside the optical truth."""
    folder = os.environ.get("TERAZI_DATA")
    if not folder:
        pytest.skip("TERAZI_DATA is unset: no recording of an IMU to play")
    whole = load_trial(find_trials(Path(folder) / "attitude" / "broad")[0])
    begin = int(np.argmax(whole.moving)) - round(3.0 * whole.rate_hz)  # at rest before
    part = slice(begin, begin + round(TRIAL_S * whole.rate_hz))
    names = ("gyro_b_counts", "acc_b_counts", "mag_b_counts", "truth_wb", "moving")
    return replace(whole, **{name: getattr(whole, name)[part] for name in names})


def test_a_recording_played_into_the_imu_gives_the_hosts_bits_and_its_score(uno, trial, tmp_path):
    """The part's own low-pass delays what it feels, and the device runs at its own 500 Hz."""
    virtual = uno.truth("play a recording")
    virtual.imu.fit().feel(
        acc_g=(trial.acc_b_counts / 2048, trial.rate_hz),
        gyro_deg_s=(trial.gyro_b_counts / 16.384, trial.rate_hz),
    )
    uno.link.hello()
    keep(uno, uart_baud=2, imu_every=1, stream_mask=RAW)
    recording = record(uno, tmp_path / "a.terazi", TRIAL_S)
    assert_same_bits(recording)

    told = recording.inertial.attitude
    rows = np.round((told["device_us"] / 1e6 - PART_DELAY_S) * trial.rate_hz).astype(int)
    counted = (rows >= 0) & (rows < len(trial.moving))
    counted[counted] &= trial.scored[rows[counted]]
    device = attitude_errors(
        unit(quats_of(told))[counted], trial.truth_wb[rows[counted]], heading_is_free=True
    )
    host = score(
        [trial], lambda one: estimate(one, mode=6, filter="second_order"), heading_is_free=True
    ).trials[trial.name]
    assert counted.sum() > 10_000
    assert abs(device.inclination_rmse_deg - host.inclination_rmse_deg) < 0.1
    assert device.total_rmse_deg < host.total_rmse_deg + 0.5


# --- faults ---


def told_us_of(received, fault, *, holds):
    """When it was told that a fault came or went, in device_us."""
    return [
        one.device_us
        for one in received
        if isinstance(one.message, Fault)
        and one.message.changed & fault
        and bool(one.message.faults & fault) == holds
    ]


BREAKS = {
    "unplugged": (lambda uno: uno.imu.unplug(), lambda uno: uno.imu.plug()),
    "SDA stuck": (lambda uno: uno.bus.fault("sda_stuck"), lambda uno: uno.bus.clear_faults()),
    "SCL stuck": (lambda uno: uno.bus.fault("scl_stuck"), lambda uno: uno.bus.clear_faults()),
    "deaf": (lambda uno: uno.bus.fault("deaf"), lambda uno: uno.bus.clear_faults()),
    "reset": (lambda uno: uno.imu.power_cycle(), lambda _uno: None),
}


@pytest.mark.parametrize(
    ("what", "mode"), [*((what, 1) for what in BREAKS), ("SDA stuck", 2), ("reset", 2)]
)
def test_a_bus_or_imu_that_fails_is_told_at_once_and_comes_back_with_its_bias(uno, what, mode):
    breaks, mends = BREAKS[what]
    virtual = fitted(uno, gyro_deg_s=(2.0, -1.5, 1.0))
    uno.load(grams=250.0)
    uno.link.hello()
    put(uno, SettingKey.IMU_MODE, mode)
    before = newest(uno.wait(5.5), ImuStatus)
    assert before.bias_x_q16
    broken_us = virtual.seconds_since_reset * 1e6
    breaks(virtual)
    away = uno.wait(1.0)
    mended_us = virtual.seconds_since_reset * 1e6 if what != "reset" else broken_us
    mends(virtual)
    back = uno.wait(2.5)

    (told_us,) = told_us_of(away, FaultFlag.IMU_LOST, holds=True)
    assert -BOOT_US < told_us - broken_us <= SEEN_US
    restarted = [
        one
        for one in attitudes(away + back)
        if one.device_us > told_us and one.message.flags & AttitudeFlag.RESTARTED
    ]
    assert restarted[0].device_us - mended_us <= BACK_US
    assert told_us_of(away + back, FaultFlag.IMU_LOST, holds=False)
    after = newest(back, ImuStatus)
    assert after.losses == before.losses + 1
    for axis in "xyz":
        name = f"bias_{axis}_q16"
        assert abs(getattr(after, name) - getattr(before, name)) < 65536 // 2
    _assert_weighing_undisturbed(away + back)


def _assert_weighing_undisturbed(received):
    samples = [one.message for one in received if isinstance(one.message, Sample)]
    numbers = [one.conversion for one in samples]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    weights = [one.message for one in received if isinstance(one.message, Weight)]
    assert len(weights) > 20
    assert all(one.weight_flags & WeightFlag.STABLE for one in weights)


def test_without_an_imu_there_is_no_fault_and_no_attitude(uno):
    uno.truth("be without an IMU")
    uno.link.hello()
    received = uno.wait(3.0)
    assert not attitudes(received)
    assert not [one for one in received if isinstance(one.message, ImuStatus)]
    assert not uno.link.status().faults_seen & FaultFlag.IMU_LOST


@pytest.mark.parametrize("identity", [0x98, 0x72, 0x70])
def test_a_sibling_serves_alike_and_its_identity_is_told(uno, identity):
    virtual = uno.truth("be another part")
    virtual.imu.fit(who_am_i=identity)
    uno.link.hello()
    received = uno.wait(2.5)
    assert newest(received, ImuStatus).identity == identity
    assert len(attitudes(received)) > 100


def test_boards_wired_without_int_are_paced_by_the_timer(uno):
    virtual = fitted(uno)
    virtual.imu.wire_int(None)
    uno.link.hello()
    received = uno.wait(3.0)
    assert newest(received, ImuStatus).missed == 0
    assert len(attitudes(received)) > 250


# --- beside the scale ---


def test_a_platform_askew_is_told_at_rest_and_only_beyond_the_limit(uno):
    virtual = fitted(uno, acc_g=(0.0, 0.03, 0.99955))
    uno.link.hello()
    received = uno.wait(6.0)
    assert uno.link.status().faults & FaultFlag.ASKEW
    assert newest(received, Weight)
    put(uno, SettingKey.IMU_TILT_LIMIT_MRAD, 40)
    uno.wait(1.5)
    assert not uno.link.status().faults & FaultFlag.ASKEW
    virtual.imu.feel(acc_g=(0.0, 0.06, 0.9982))
    uno.wait(8.0)
    assert uno.link.status().faults & FaultFlag.ASKEW
    put(uno, SettingKey.IMU_TILT_LIMIT_MRAD, 0)
    uno.wait(1.5)
    assert not uno.link.status().faults & FaultFlag.ASKEW


@pytest.mark.parametrize(
    "detector", [1, 2, 3, 4, 5], ids=["shoe", "are", "variance", "magnitude", "gru"]
)
def test_each_detector_says_still_and_moving_and_the_lamp_shows_it(uno, detector):
    def shaking(t_s):
        size = ((t_s > 3.0) & (t_s < 5.0)).astype(float)[:, None]
        return np.sin(2 * np.pi * 6.0 * t_s)[:, None] * size * np.array([60.0, 30.0, 90.0])

    def shaken(t_s):
        return shaking(t_s) / 100.0 + np.array([0.0, 0.0, 1.0])

    virtual = fitted(uno, acc_g=shaken, gyro_deg_s=shaking)
    uno.link.hello()
    put(uno, SettingKey.IMU_ZUPT, detector)
    put(uno, SettingKey.IMU_LAMP, 1)
    still, lit = {}, {}
    for at_s, wanted in ((2.5, True), (4.0, False), (6.5, True)):
        found = attitudes(uno.wait(at_s - virtual.seconds_since_reset))
        still[at_s] = bool(found[-1].message.flags & AttitudeFlag.STILL)
        lit[at_s] = bool(virtual.peek(PORTB)[0] & LED)
        assert still[at_s] == wanted
    assert lit == still


def test_an_orientation_turns_the_axes_and_one_that_is_none_is_refused(uno):
    fitted(uno, acc_g=(0.6, 0.0, 0.8))
    uno.link.hello()
    put(uno, SettingKey.IMU_ORIENTATION, 0b100001)  # x along +y, y along -x
    found = attitudes(uno.wait(1.5))
    assert angle_deg(up_b(quats(found))[-1:], np.array([0.0, -0.6, 0.8])).max() < 1.0
    with pytest.raises(CommandRefused):
        put(uno, SettingKey.IMU_ORIENTATION, 0)
    found = attitudes(uno.wait(0.5))
    assert angle_deg(up_b(quats(found))[-1:], np.array([0.0, -0.6, 0.8])).max() < 1.0
