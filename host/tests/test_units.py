# SPDX-License-Identifier: MIT
"""Units: the wire's integers in what people read."""

import pytest

from terazi import units


def test_fixed_point_formats_are_undone():
    assert units.counts_from_q7(-129) == -1.0078125
    assert units.hz_from_q16(82 << 16) == 82.0
    assert units.g_from_mg(-1500) == -1.5
    assert units.s_from_us(2_500_000) == 2.5


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
