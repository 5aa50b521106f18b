# SPDX-License-Identifier: MIT
"""mahony.c against float64: the same input and constants, exact rotations (notes/mahony.md)."""

import os
from pathlib import Path

import numpy as np
import pytest

from terazi.cshared import Mahony, Rest, mahony_block
from terazi.design import mahony as design
from terazi.models import mahony as model

pytestmark = pytest.mark.no_cover  # millions of steps of a model that other tests cover too

RATE_HZ = 285.714285714
CONFIG = design.named("286hz")
Q30 = 1 << 30
MINUTES_10 = round(600 * RATE_HZ)
INCLINATION_RMS_MAX_DEG = 0.002
TOTAL_MAX_DEG = 0.02
EULER_MAX_RAD = 3e-4


def field_of(quats, vector_w):
    """A world vector in body axes, (n, 3)."""
    return np.einsum("nji,j->ni", np.array([model.rotation(q) for q in quats]), vector_w)


def tumbling(count, rate_deg_s, seed):
    """Gyroscope's counts and the attitudes that exact rotations by them give."""
    rng = np.random.default_rng(seed)
    t = np.arange(count) / RATE_HZ
    direction = np.stack([np.sin(2 * np.pi * f * t + p) for f, p in rng.uniform(0.1, 0.9, (3, 2))])
    direction /= np.linalg.norm(direction, axis=0)
    gyro = np.rint(rate_deg_s * 16.384 * direction.T).astype(np.int16)
    quats, quat = np.empty((count, 4)), np.array([1.0, 0.0, 0.0, 0.0])
    for n, half in enumerate(gyro * (CONFIG["gyro_q33"] / 2**33)):
        quats[n] = quat  # the attitude in which sample n of the accelerometer is taken
        quat = model.product(quat, model.turned(half))
        quat /= np.linalg.norm(quat)
    return gyro, quats, np.concatenate([quats[1:], quat[None]])


@pytest.mark.parametrize("rate_deg_s", [60.0, 700.0])
def test_mahony_keeps_to_exact_rotations_over_10_minutes(rate_deg_s):
    """True gravity, so that the corrections have nothing to do but the C's own errors."""
    gyro, before, after = tumbling(MINUTES_10, rate_deg_s, seed=4)
    acc = np.rint(2048 * field_of(before, [0, 0, 1])).astype(np.int16)
    quats = mahony_block(gyro, acc, config=CONFIG) / Q30
    inclination, total = model.errors_deg(quats[::50], after[::50])
    assert np.sqrt(np.mean(inclination**2)) < INCLINATION_RMS_MAX_DEG
    assert total.max() < TOTAL_MAX_DEG


@pytest.mark.parametrize("mode", design.MODES)
def test_mahony_keeps_to_the_model_in_motion(mode):
    """One minute of motion with accelerations of a g, a third of a minute in the other modes."""
    config = design.config_at(RATE_HZ, mode)
    count = round((60 if mode == "second_order" else 20) * RATE_HZ)
    gyro, before, _ = tumbling(count, 250.0, seed=5)
    rng = np.random.default_rng(6)
    t = np.arange(count)[:, None] / RATE_HZ
    push = np.sin(2 * np.pi * t * rng.uniform(0.5, 4, 3)) * [1.0, 0.7, 0.5]
    acc = np.rint(2048 * (field_of(before, [0, 0, 1]) + push)).astype(np.int16)
    bias_q16 = (123_456, -654_321, 77_777)
    quats = mahony_block(gyro, acc, config=config, bias_q16=bias_q16) / Q30
    bias = np.tile(np.array(bias_q16) / 65536, (count, 1))
    truth = model.run(gyro, acc, config, bias_counts=bias)
    inclination, total = model.errors_deg(quats[::20], truth[::20])
    # classic: a / |a| has 15 bits and |a| is an integer, so that u itself differs by 1e-4
    allowance = 10 if mode == "classic" else 1
    assert np.sqrt(np.mean(inclination**2)) < allowance * INCLINATION_RMS_MAX_DEG
    assert total.max() < allowance * TOTAL_MAX_DEG


def test_mahony_with_magnetometer_keeps_to_the_model():
    config = design.named("286hz")
    count = round(40 * RATE_HZ)
    gyro, before, _ = tumbling(count, 120.0, seed=7)
    acc = np.rint(2048 * field_of(before, [0, 0, 1])).astype(np.int16)
    mag = field_of(before, [0, 2000, -4500])
    # A disturbance in norm: where it is noticed a block sooner or later it turns but 3e-3 deg.
    magnet = slice(count // 3, count // 2)
    mag[magnet] = field_of(before[magnet], [200, 3000, -6000])
    mag = np.rint(mag).astype(np.int16)
    quats = mahony_block(gyro, acc, mag, config=config) / Q30
    truth = model.run(gyro, acc, config, mag_counts=mag)
    start = model.START_LEN * (config["ramp_mask"] + 1)  # it follows every count of acceleration
    inclination, total = model.errors_deg(quats[start::20], truth[start::20])
    assert np.sqrt(np.mean(inclination**2)) < INCLINATION_RMS_MAX_DEG
    assert total.max() < TOTAL_MAX_DEG


def test_mahony_bridges_a_magnet_that_a_plain_filter_follows():
    count = round(40 * RATE_HZ)
    rest = np.zeros((count, 3), dtype=np.int16)
    acc = rest + np.array([0, 0, 2048], dtype=np.int16)
    mag = np.tile(np.array([0, 2000, -4500], dtype=np.int16), (count, 1))
    mag[count // 4 :] = [2500, 1000, -3000]
    plain = design.config_at(RATE_HZ) | {"mag_reject_len": 0}
    headings = []
    for config in (CONFIG, plain):
        w, _, _, z = mahony_block(rest, acc, mag, config=config)[-1] / Q30
        headings.append(abs(np.degrees(2 * np.arctan2(z, w))))
    assert headings[0] < 1.0
    assert headings[1] > 20.0


def test_mahony_accepts_another_field_that_stays_while_the_board_turns():
    """The norm of the new field is far off, its azimuth a little: it is rejected, then believed."""
    rate_hz, turning = 100.0, 655
    config = design.config_at(rate_hz, heading_tau_s=1.0, accept_s=5.0, reject_s=60.0)
    count = round(40 * rate_hz)
    angle = np.arange(count) * turning * config["gyro_q33"] * config["steps"] / 2**32
    east, north, up = np.where(np.arange(count) < count // 4, [[0], [2000], [-4500]],
                               [[800], [3500], [-2000]])  # fmt: skip
    sine, cosine = np.sin(angle), np.cos(angle)
    mag = np.stack([east * cosine + north * sine, north * cosine - east * sine, up], axis=1)
    gyro = np.tile(np.array([0, 0, turning], dtype=np.int16), (count, 1))
    acc = np.tile(np.array([0, 0, 2048], dtype=np.int16), (count, 1))
    quats = mahony_block(gyro, acc, np.rint(mag).astype(np.int16), config=config) / Q30
    heading = np.unwrap(2 * np.arctan2(quats[:, 3], quats[:, 0])) - angle
    off_deg = np.degrees(heading - heading[count // 8])
    assert abs(off_deg[count // 4 + round(4 * rate_hz)]) < 0.5  # rejected
    assert abs(off_deg[-1] - np.degrees(np.arctan2(800, 3500))) < 0.5  # believed


def test_mahony_euler_angles_are_those_of_the_quaternion():
    mahony = Mahony("286hz")
    rng = np.random.default_rng(8)
    mahony.update((0, 0, 0), (0, 0, 2048))
    for _ in range(2000):
        mahony.update(rng.integers(-32768, 32768, 3), (0, 0, 2048))
        roll, pitch, yaw = model.euler(mahony.quat_wb)
        if abs(pitch) > np.radians(89):
            continue
        got = np.array(mahony.euler_q13) / 8192
        off = np.remainder(got - [roll, pitch, yaw] + np.pi, 2 * np.pi) - np.pi
        assert np.abs(off).max() < EULER_MAX_RAD


def test_mahony_euler_angles_do_not_jump_through_the_lock():
    """Up through 90 deg of pitch, a little aside of it: roll and yaw turn over by 180 deg, as they
    must; away from that no step is larger than what was turned."""
    mahony = Mahony("286hz")
    mahony.update((0, 0, 0), (0, 0, 2048))
    sums = []
    for _ in range(1500):
        mahony.update((0, -400, 0), (0, 0, 0))
        roll, pitch, yaw = mahony.euler_q13
        sums.append((roll, pitch, yaw))
    sums = np.array(sums, dtype=float) / 8192
    assert sums[:, 1].min() < np.radians(-89.9)
    step = np.abs(np.diff(sums[:, 1]))
    assert step.max() < 2 * np.radians(400 / 16.384 / RATE_HZ) + 2e-3
    # yaw + roll is what remains defined when the nose points down
    both = np.unwrap(sums[:, 0] + sums[:, 2])
    assert np.abs(np.diff(both)).max() < 0.02


@pytest.mark.skipif("TERAZI_DATA" not in os.environ, reason="TERAZI_DATA is not set")
def test_mahony_keeps_to_the_model_on_recordings():
    paths = sorted((Path(os.environ["TERAZI_DATA"]) / "attitude" / "broad").glob("*.npz"))
    if not paths:
        pytest.skip("TERAZI_DATA holds no attitude/broad")
    for path in paths[::6]:
        data = np.load(path)
        gyro, acc = (np.ascontiguousarray(data[name], dtype=np.int16) for name in ("gyr", "acc"))
        bias_q16, _ = Rest("286hz").block(gyro, acc)
        quats = mahony_block(gyro, acc, config=CONFIG, bias_q16=bias_q16) / Q30
        truth = model.run(gyro, acc, CONFIG, bias_counts=bias_q16 / 65536)
        inclination, total = model.errors_deg(quats[::50], truth[::50])
        assert np.sqrt(np.mean(inclination**2)) < INCLINATION_RMS_MAX_DEG, path.name
        assert total.max() < TOTAL_MAX_DEG, path.name
