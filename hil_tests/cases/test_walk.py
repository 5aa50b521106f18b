# SPDX-License-Identifier: MIT
"""A foot with the board on it walks a square: its capture is that square, by the host's detector of
zero velocity and by the device's own."""

import os
from dataclasses import replace

import numpy as np
import pytest

from terazi.applications.walks import Options, Truth, estimate, load_walk, path_errors, simulator
from terazi.applications.walks.formats import save_walk
from terazi.control.settings import apply_settings, read_settings
from terazi.link.generated.messages import (
    ImuStatus,
    SaveSettings,
    SetStream,
    SettingsState,
    StreamFlag,
)
from terazi.link.generated.settings import SETTINGS_BY_NAME
from terazi.recorder import Recorder, load_recording
from virtual_uno.motion import read_motion

MOTION_HZ = 1000.0  # finer than the device samples
PART_DELAY_S = 2.8e-3  # DLPF 2
CHOICES = {name: dict(SETTINGS_BY_NAME[name].choices) for name in ("imu.zupt", "uart.baud")}
SET = {
    "imu.every": 1,
    "stream.mask": int(StreamFlag.IMU | StreamFlag.ATTITUDE | StreamFlag.STATUS),
}
DETECTORS = ("adaptive_shoe", "device")
RATES = {500: (1, 500_000), 1000: (2, 1_000_000)}  # imu.mode, and what carries every sample
SQUARE_M = 0.1  # mean error of a path of 8 m
LONG_M = 0.25  # and of 44 m
LONG = pytest.mark.skipif("TERAZI_LONG" not in os.environ, reason="TERAZI_LONG is unset: minutes")


def short_square():
    """One stride a side, two for each corner: 8 m in 16 s."""
    pieces = simulator.stand(2.0)
    for _side in range(4):
        pieces += simulator.strides(1) + simulator.turning(np.pi / 2, count=2)
    return [*pieces, *simulator.stand(1.0)]


def walked(uno, tmp_path, pieces, *, rate_hz=500, zupt="shoe"):
    """The capture of this walk from the reset on, read, with its truth at each sample."""
    mode, baud = RATES[rate_hz]
    chosen = {
        "imu.mode": mode,
        "uart.baud": CHOICES["uart.baud"][f"b{baud}"],
        "imu.zupt": CHOICES["imu.zupt"][zupt],
    }
    made = simulator.simulate(pieces, seed=7, rate_hz=MOTION_HZ)
    save_walk(tmp_path / "motion.npz", made)
    motion = read_motion(str(tmp_path / "motion.npz"))
    virtual = uno.truth("walk")
    virtual.imu.fit().noise()
    virtual.imu.feel(acc_g=motion.acc_g, gyro_deg_s=motion.gyro_deg_s)
    uno.link.hello()
    uno.link.command(SetStream(mask=int(StreamFlag.STATUS)))  # whatever the rates, answers come
    apply_settings(uno.link, SET | chosen)
    uno.link.command(SaveSettings())
    while uno.link.status().settings_state == SettingsState.WRITING:
        uno.wait(0.1)
    recorder = Recorder(tmp_path / "foot.terazi")
    uno.link.on_bytes = recorder.on_bytes
    recorder.begin(port="virtual", baud=baud, age_s=uno.link.now_s())
    virtual.uart.host_baud = baud
    uno.reset()
    read_settings(uno.link, SETTINGS_BY_NAME)
    for received in uno.wait(made.t_s[-1] - virtual.seconds_since_reset):
        recorder.add(received)
    uno.link.on_bytes = None
    recorder.finish(uno.link.stream, uno.link.now_s())
    walk = load_walk(tmp_path / "foot.terazi")
    assert (walk.notes, walk.rate_hz, walk.device.detector) == ((), rate_hz, zupt)
    recording = load_recording(tmp_path / "foot.terazi", needs_samples=False)
    begin_s = recording.inertial.imu["device_us"][0] / 1e6 - PART_DELAY_S
    pos = [np.interp(begin_s + walk.t_s, made.t_s, each) for each in made.truth.pos_t_m.T]
    truth = Truth(np.arange(len(walk)), np.column_stack(pos), from_start=True)
    health = recording.of_kind(ImuStatus)[-1][1].message
    assert (recording.frames_lost, health.missed, health.railed) == (0, 0, 0)
    return replace(walk, truth=truth)


def error_m(walk, detector, *, causal):
    options = Options(detector=detector, causal=causal, roll_share=0.0)  # the foot does not roll
    result = estimate(walk, options)
    return path_errors(result.walk, result.path.pos_w_m).rmse_3d_m


@pytest.mark.parametrize("rate_hz", RATES)
def test_a_square_is_walked_logged_and_found_again(uno, tmp_path, rate_hz):
    walk = walked(uno, tmp_path, short_square(), rate_hz=rate_hz)
    for detector in DETECTORS:
        for causal in (False, True):
            assert error_m(walk, detector, causal=causal) < SQUARE_M


@pytest.mark.parametrize("zupt", [name for name in CHOICES["imu.zupt"] if name != "off"])
@LONG
def test_a_square_of_10_m_is_found_by_each_of_the_device_s_detectors(uno, tmp_path, zupt):
    walk = walked(uno, tmp_path, simulator.square(10.0), zupt=zupt)
    for detector in DETECTORS:
        assert error_m(walk, detector, causal=False) < LONG_M
