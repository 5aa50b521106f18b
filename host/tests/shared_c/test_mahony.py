# SPDX-License-Identifier: MIT
"""mahony.c: golden vectors, laws for all inputs, and parity with the float64 model."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from terazi.cshared import MAHONY_CONFIGS, Mahony, Rest, mahony_block
from terazi.design import mahony as design
from terazi.models import exact_mahony
from terazi.models.vectors import golden

VECTORS = golden("mahony_")
CONFIG = design.named("286hz")
RATE_HZ = 285.714285714
FIELDS = tuple(CONFIG)
Q30 = 1 << 30
START = exact_mahony.START_LEN * (CONFIG["ramp_mask"] + 1)  # samples
LEVEL = (0, 0, 2048)
NORM_ERROR_MAX = 1e-6
int16 = st.integers(-32768, 32767)
small = st.integers(-400, 400)
vectors = st.tuples(int16, int16, int16)
biases = st.tuples(*[st.integers(-(1 << 25), 1 << 25)] * 3)
modes = st.sampled_from(design.MODES)


def rows(vector, *columns):
    return list(zip(*(vector[column] for column in columns), strict=True))


def samples_of(vector):
    """(gap, gyro, acc, mag, bias) of each row."""
    gyro, acc, mag = (
        rows(vector, *(f"{sensor}_{axis}_counts" for axis in "xyz"))
        for sensor in ("gyro", "acc", "mag")
    )
    bias = rows(vector, *(f"bias_{axis}_q16" for axis in "xyz"))
    return zip(vector["gap_samples"], gyro, acc, mag, bias, strict=True)


def feed(mahony, sample, axes=9):
    gap, gyro, acc, mag, bias = sample
    if gap:
        mahony.gap(gap)
    mahony.update(gyro, acc, bias)
    if axes == 9:
        mahony.update_mag(mag)


def answers(vector):
    """Quaternion and angles after each sample, and the counts at the end."""
    mahony = Mahony({field: vector.parameter(field) for field in FIELDS})
    results = []
    for sample in samples_of(vector):
        feed(mahony, sample, vector.parameter("axes"))
        results.append((*mahony.quat_wb_q30, *mahony.euler_q13))
    return results, mahony.counts


def expected(vector):
    quats = [f"quat_{part}_q30" for part in "wxyz"]
    return rows(vector, *quats, "roll_q13", "pitch_q13", "yaw_q13")


@pytest.mark.parametrize("vector", [v for v in VECTORS if v.header["kind"] == "model"], ids=str)
def test_mahony_reproduces_vector_bit_for_bit(vector):
    results, counts = answers(vector)
    assert results == expected(vector)
    assert counts == {name: vector.parameter(f"counted_{name}") for name in counts}


@pytest.mark.parametrize("vector", [v for v in VECTORS if v.header["kind"] == "published"], ids=str)
def test_mahony_keeps_to_the_closed_form(vector):
    results, _ = answers(vector)
    off = np.abs(np.array(results, dtype=np.int64) - np.array(expected(vector), dtype=np.int64))
    assert off[:, :4].max() <= vector.parameter("tolerance_q30")
    assert off[:, 4:].max() <= vector.parameter("tolerance_q13")


samples = st.tuples(
    st.sampled_from([0] * 20 + [1, 28, 29, 65535]),
    st.one_of(vectors, st.tuples(small, small, small)),
    st.one_of(vectors, st.tuples(small, small, st.integers(1500, 2600)), st.just((0, 0, 0))),
    st.one_of(vectors, st.tuples(small, st.integers(1000, 2500), st.integers(-5000, -3000))),
    biases,
)


@settings(max_examples=60)
@given(
    mode=modes,
    rate_hz=st.floats(25.0, 2000.0),
    ki=st.sampled_from([0.0, 0.001, 0.02]),
    ramp_s=st.sampled_from([0.01, 0.05, 2.0]),
    fed=st.lists(samples, max_size=60),
)
def test_mahony_is_its_exact_twin_and_of_unit_norm_for_any_lawful_rate(
    mode, rate_hz, ki, ramp_s, fed
):
    config = design.config_at(rate_hz, mode, ki_rad_s2=ki, ramp_s=ramp_s)
    mahony, twin = Mahony(config), exact_mahony.Mahony(config)
    held = [0, 0]
    for sample in fed:
        feed(mahony, sample)
        feed(twin, sample)
        quat = mahony.quat_wb_q30
        assert quat == tuple(twin.quaternion())
        assert mahony.euler_q13 == twin.euler(held)
        assert mahony.up_b_q14 == tuple(twin.up())
        assert mahony.free_acceleration(sample[2]) == tuple(twin.free_acceleration(sample[2]))
        assert abs(np.linalg.norm(np.array(quat) / Q30) - 1) < NORM_ERROR_MAX
    assert mahony.counts == twin.counts


def test_mahony_keeps_its_norm_under_rails_for_as_long_as_they_last():
    """Every axis at its rail, signs that change at random: 10^6 samples."""
    rng = np.random.default_rng(3)
    count = 1_000_000
    for signs in (rng.choice([-1, 1], (count, 3)), np.ones((count, 3), int)):
        gyro = np.where(signs > 0, 32767, -32768).astype(np.int16)
        quats = mahony_block(gyro, np.roll(gyro, 1, axis=1), config=CONFIG)
        assert np.abs(np.linalg.norm(quats / Q30, axis=1) - 1).max() < NORM_ERROR_MAX


@given(fed=st.lists(samples, min_size=2, max_size=40), at=st.integers(0, 39), mode=modes)
def test_mahony_restored_or_copied_in_mid_stream_continues_identically(fed, at, mode):
    config = design.config_at(RATE_HZ, mode, ramp_s=0.01)
    mahony = Mahony(config)
    for sample in fed[:at]:
        feed(mahony, sample)
        _ = mahony.euler_q13
    saved, copied = mahony.save(), mahony.copy()
    restored = Mahony(config)
    restored.restore(saved)
    for sample in fed[at:]:
        for each in (mahony, copied, restored):
            feed(each, sample)
        assert mahony.quat_wb_q30 == copied.quat_wb_q30 == restored.quat_wb_q30
        assert mahony.euler_q13 == copied.euler_q13 == restored.euler_q13


def turned_about_z(array):
    """Body axes turned by 90 deg about body z: x' = y, y' = -x."""
    return np.stack([array[:, 1], -array[:, 0], array[:, 2]], axis=1)


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32 - 1))
def test_mahony_of_a_board_mounted_a_quarter_turn_round_is_turned_by_a_quarter(seed):
    """But for what it matters that the world's level axes take turns, the heading being free; it
    starts at rest."""
    gyro, acc = motion(seed, 400)
    gyro = np.concatenate([np.zeros((START, 3), dtype=np.int16), gyro])
    acc = np.concatenate([np.tile(np.array(LEVEL, dtype=np.int16), (START, 1)), acc])
    quats = mahony_block(gyro, acc, config=CONFIG) / Q30
    turned = mahony_block(turned_about_z(gyro), turned_about_z(acc), config=CONFIG) / Q30
    up = np.stack([up_of(quat) for quat in quats[::40]])
    up_turned = np.stack([up_of(quat) for quat in turned[::40]])
    assert np.abs(turned_about_z(up) - up_turned).max() < 5e-3


def up_of(quat):
    w, x, y, z = quat
    return np.array([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])


def motion(seed, count, *, rate_deg_s=300.0):
    """Counts of a board that is turned smoothly by up to rate_deg_s and shaken by a g."""
    rng = np.random.default_rng(seed)
    t = np.arange(count)[:, None] / RATE_HZ
    phases, rates = rng.uniform(0, 7, (2, 3)), rng.uniform(0.2, 3.0, (2, 3))
    gyro = rate_deg_s * 16.384 * np.sin(2 * np.pi * rates[0] * t + phases[0])
    acc = 2048 * np.sin(2 * np.pi * rates[1] * t + phases[1]) + [0, 0, 2048]
    return np.rint(gyro).astype(np.int16), np.rint(acc).astype(np.int16)


@pytest.mark.parametrize("name", ["286hz", "500hz", "1000hz"])
@pytest.mark.parametrize("up", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, -1, 0), (0.6, 0, -0.8)])
def test_mahony_started_at_any_attitude_stands_within_half_a_second(up, name):
    acc = np.rint(2048 * np.array(up)).astype(int)
    up = acc / np.linalg.norm(acc)
    mahony, count = Mahony(name), int(name.removesuffix("hz")) // 2
    for n in range(2 * count):
        mahony.update((0, 0, 0), acc)
        if n >= count:
            assert np.degrees(np.linalg.norm(np.cross(up_of(mahony.quat_wb), up))) < 0.02
            assert up_of(mahony.quat_wb) @ up > 0


@given(
    direction=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
    g=st.floats(0.8, 1.25),
)
def test_mahony_starts_with_acceleration_upwards_and_turns_no_further(direction, g):
    acc = np.rint(2048 * g * np.array(direction) / np.linalg.norm(direction)).astype(int)
    mahony = Mahony("286hz")
    for _ in range(START):
        mahony.update((0, 0, 0), acc)
    angle = np.arctan2(
        np.linalg.norm(np.cross(up_of(mahony.quat_wb), acc)), up_of(mahony.quat_wb) @ acc
    )
    assert np.degrees(angle) < 0.02


def test_mahony_starts_while_the_board_turns():
    """About its vertical, 300 deg/s: the heading is the gyroscope's from the first sample on."""
    mahony = Mahony("286hz")
    for _ in range(START):
        mahony.update((0, 0, 4915), LEVEL)
    w, x, y, z = mahony.quat_wb
    turned_deg = START * 4915 / 16.384 / RATE_HZ
    assert abs(np.remainder(np.degrees(2 * np.arctan2(z, w)) - turned_deg + 180, 360) - 180) < 0.05
    assert np.hypot(x, y) < 1e-4


@settings(max_examples=20)
@given(azimuth=st.floats(-np.pi, np.pi), level=st.integers(200, 4000))
def test_mahony_starts_with_the_field_northwards(azimuth, level):
    """From any heading, even the opposite one, within 4 s at 1 kHz."""
    field = (round(level * np.sin(azimuth)), round(level * np.cos(azimuth)), -level)
    count = 400 + 4000
    gyro = np.zeros((count, 3), dtype=np.int16)
    acc, mag = (np.tile(np.array(each, dtype=np.int16), (count, 1)) for each in (LEVEL, field))
    w, _, _, z = mahony_block(gyro, acc, mag, config="1000hz")[-1] / Q30
    off = 2 * np.arctan2(z, w) - np.arctan2(field[0], field[1])
    assert abs(np.degrees(np.remainder(off + np.pi, 2 * np.pi) - np.pi)) < 0.2


def test_mahony_counts_samples_without_acceleration_and_goes_on_by_the_gyroscope():
    mahony = Mahony("286hz")
    for _ in range(START):
        mahony.update((0, 0, 0), LEVEL)
    for _ in range(100):
        mahony.update((0, 0, 3000), (0, 0, 0))
    w, x, y, z = mahony.quat_wb
    assert abs(2 * np.arctan2(z, w) - 100 * 2 * 3000 * CONFIG["gyro_q33"] / 2**33) < 1e-4
    assert np.hypot(x, y) < 1e-4
    assert mahony.counts["acc_zero"] == 100


def test_mahony_bridges_a_short_gap_with_the_last_rate_and_starts_anew_after_a_long_one():
    mahony = Mahony("286hz")
    for _ in range(START + 5):
        mahony.update((0, 0, 3000), LEVEL)
    bridged, stepped = mahony.copy(), mahony.copy()
    bridged.gap(20)
    for _ in range(20):
        stepped.update((0, 0, 3000), LEVEL)
    np.testing.assert_allclose(bridged.quat_wb, stepped.quat_wb, atol=1e-5)
    mahony.gap(CONFIG["gap_max"] + 1)
    for _ in range(START):
        mahony.update((0, 0, 0), (2048, 0, 0))
    np.testing.assert_allclose(up_of(mahony.quat_wb), [1, 0, 0], atol=1e-3)
    assert mahony.counts["gaps"] == 1


def test_mahony_standing_up_after_a_gap_keeps_its_heading():
    """To 4 % of what it is turned by: its two axes take turns."""
    mahony = Mahony("286hz")
    for _ in range(START):
        mahony.update((0, 0, 4915), LEVEL)
    w, _, _, z = mahony.quat_wb
    mahony.gap(65535)
    for _ in range(START):
        mahony.update((0, 0, 0), (300, 0, 2026))
    after_w, _, _, after_z = mahony.quat_wb
    off = 2 * (np.arctan2(after_z, after_w) - np.arctan2(z, w))
    tilt = np.arctan2(300, 2026)
    assert abs(np.remainder(off + np.pi, 2 * np.pi) - np.pi) < 0.04 * tilt


def test_mahony_learns_the_bias_by_ki():
    config = design.config_at(RATE_HZ, ki_rad_s2=0.02)
    count = round(120 * RATE_HZ)
    gyro = np.tile(np.array([20, -30, 0], dtype=np.int16), (count, 1))
    acc = np.tile(np.array([0, 0, 2048], dtype=np.int16), (count, 1))
    tilt = [
        np.degrees(np.arccos(up_of(mahony_block(gyro, acc, config=each)[-1] / Q30)[2]))
        for each in (CONFIG, config)
    ]
    assert tilt[0] > 1.0
    assert tilt[1] < 0.05


def test_mahony_block_gives_what_single_calls_give_with_and_without_rest():
    gyro, acc = motion(1, 300)
    mag = np.tile(np.array([0, 2000, -4500], dtype=np.int16), (300, 1))
    one, rest = Mahony("286hz"), Rest("286hz")
    expected_quats = []
    for g, a, m in zip(gyro, acc, mag, strict=True):
        rest.update(g, a)
        one.update(g, a, rest.bias_q16)
        one.update_mag(m)
        expected_quats.append(one.quat_wb_q30)
    quats = mahony_block(gyro, acc, mag, rest_config="286hz")
    assert quats.tolist() == [list(each) for each in expected_quats]
    fixed = mahony_block(gyro, acc, bias_q16=(70_000, -70_000, 5))
    each = mahony_block(gyro, acc, bias_q16=np.tile([70_000, -70_000, 5], (300, 1)))
    assert np.array_equal(fixed, each)


@pytest.mark.parametrize(
    ("broken", "complaint"),
    [
        ({"gyro_q33": 16129}, "beyond"),
        ({"steps": 0}, "beyond"),
        ({"mode": 3}, "beyond"),
        ({"correct_q18": 4096}, "beyond"),
        ({"lowpass_q16": 0}, "beyond"),
        ({"lowpass_q16": 4096}, "beyond"),
        ({"ramp_mask": 20}, "beyond"),
        ({"start_shift": 31}, "beyond"),
        ({"mag_correct_q21": 0}, "beyond"),
        ({"mag_learn_q16": 70_000}, "configuration"),
    ],
)
def test_mahony_refuses_what_would_overflow(broken, complaint):
    with pytest.raises(ValueError, match=complaint):
        Mahony(CONFIG | broken)


def test_mahony_configurations_are_those_of_the_specification():
    assert list(MAHONY_CONFIGS) == [entry["name"] for entry in design.spec()["config"]]
    with pytest.raises(ValueError, match="no configuration"):
        Mahony("42hz")
    with pytest.raises(ValueError, match="contract is broken"):
        design.config_at(5.0)
