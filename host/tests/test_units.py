# SPDX-License-Identifier: MIT
"""Units: the wire's integers in what people read."""

import pytest

from terazi import units
from terazi.design import mahony


def test_fixed_point_formats_are_undone():
    assert units.counts_from_q7(-129) == -1.0078125
    assert units.hz_from_q16(82 << 16) == 82.0
    assert units.g_from_mg(-1500) == -1.5
    assert units.s_from_us(2_500_000) == 2.5


def test_imu_counts_are_those_of_the_specification():
    sensor = mahony.spec()["sensor"]
    assert sensor["gyro_counts_per_deg_s"] == units.GYRO_COUNTS_PER_DEG_S
    assert sensor["acc_counts_per_g"] == units.ACC_COUNTS_PER_STANDARD_GRAVITY
    assert units.deg_s_from_counts(16_384) == 1000.0
    assert units.deg_s_from_q16(16_384 << 16) == 1000.0
    assert units.m_s2_from_counts(-2048) == -9.80665
    assert units.deg_c_from_counts(340) == pytest.approx(37.53)
    assert units.one_from_q14(-(1 << 14)) == -1.0
    assert units.one_from_q30(1 << 29) == 0.5


def test_tilt_is_from_the_vertical():
    assert units.tilt_deg((0.0, 0.0, 1.0)) == 0.0
    assert units.tilt_deg((0.0, -2.0, 0.0)) == 90.0
    assert units.tilt_deg((0.0, 0.0, -1.0)) == 180.0


@pytest.mark.parametrize(
    ("size_bytes", "words"),
    [(0, "0 B"), (999, "999 B"), (1500, "1.5 kB"), (7_300_000_000_000, "7300.0 GB")],
)
def test_sizes_for_people(size_bytes, words):
    assert units.show_bytes(size_bytes) == words


@pytest.mark.parametrize(
    ("duration_s", "words"),
    [
        (0.04, "0.0 s"),
        (59.9, "59.9 s"),
        (59.99, "1 min 00 s"),
        (245, "4 min 05 s"),
        (7380, "2 h 03 min"),
    ],
)
def test_durations_for_people(duration_s, words):
    assert units.show_duration(duration_s) == words


def test_weights_for_people():
    assert units.show_g(-12345.678) == "-12 345.68 g"
