# SPDX-License-Identifier: MIT
"""What is said of calibration points: contradictions named, sense kept, good cells not bothered."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.calibration.points import (
    check_mass_mg,
    examine,
    line_through,
    reach_warning,
    refuse_mass,
    residuals,
)
from terazi.link.generated.messages import Point

E_MG = 1000
COUNTS_PER_G = 429.55


def point(mass_g, counts_per_g=COUNTS_PER_G, *, off_counts=0.0, zero_counts=84_000):
    counts = zero_counts + mass_g * counts_per_g + off_counts
    return Point(0, round(counts * 128), round(mass_g * 1000))


def examined(points, new, **more):
    return examine(points, new, interval_mg=E_MG, **more)


@pytest.mark.parametrize("turned", [1.0, -1.0], ids=["rising", "falling"])
def test_points_of_a_good_cell_are_taken_without_a_word(turned):
    taken = []
    for mass_g in (0, 5000, 2500, 1000, 4000):
        bend = 0.001 * mass_g * (5000 - mass_g) / 5000  # 0.025 % of the range at its middle
        new = point(mass_g + bend, turned * COUNTS_PER_G)
        new = Point(0, new.counts_q7, mass_g * 1000)
        assert examined(taken, new) is None
        taken.append(new)


def test_a_mass_said_ten_times_too_large_is_doubted_with_what_the_cell_says():
    taken = [point(0), point(1000)]
    finding = examined(taken, Point(0, point(50).counts_q7, 500_000))
    assert not finding.is_refusal
    assert "you entered 500.0 g, by the points so far the cell says about 50.0 g" in finding.text


def test_the_first_load_is_compared_with_the_calibration_of_before():
    finding = examined([point(0)], Point(0, point(50).counts_q7, 500_000), before_mg=50_300.0)
    assert "you entered 500.0 g, by its calibration until now the cell says about 50.3 g" in (
        finding.text
    )
    for before_mg in (None, 500_000.0, 260_000.0, 0.0, -50_000.0):
        new = Point(0, point(500).counts_q7, 500_000)
        assert examined([point(0)], new, before_mg=before_mg) is None, before_mg


def test_a_load_that_moves_the_cell_the_other_way_is_refused_and_both_are_named():
    finding = examined([point(0), point(1000), point(2000)], point(3000, off_counts=-900_000))
    assert finding.is_refusal
    assert "3 000.0 g" in finding.text
    assert "2 000.0 g" in finding.text
    assert "the other way" in finding.text


@pytest.mark.parametrize("moved_counts", [0, 3, -3])
def test_a_mass_that_was_not_put_on_is_refused(moved_counts):
    new = Point(0, point(0).counts_q7 + 128 * moved_counts, 500_000)
    finding = examined([point(0)], new)
    assert finding.is_refusal
    assert f"differ by {abs(moved_counts)} counts only" in finding.text


def test_steepness_is_bounded_as_on_the_device():
    assert examined([Point(0, 0, 0)], Point(0, 128 * 1000, 127_999)) is None
    assert examined([Point(0, 0, 0)], Point(0, 128 * 1000, 128_000)).is_refusal


@pytest.mark.parametrize(
    ("mass_mg", "words"),
    [
        (500_000_001, "500 kg at most"),
        (9_999, "too near to 0.0 g"),
        (1_009_999, "too near to 1 000.0 g"),
    ],
)
def test_a_mass_is_refused_before_it_is_put_on(mass_mg, words):
    finding = refuse_mass([point(0), point(1000)], mass_mg, E_MG)
    assert words in finding.text
    assert finding.is_refusal


def test_a_mass_that_is_there_already_may_be_repeated_also_as_the_eighth():
    points = [point(g) for g in range(0, 800, 100)]
    assert refuse_mass(points, 300_000, E_MG) is None
    assert "8 points at most" in refuse_mass(points, 350_000, E_MG).text


@given(
    slope=st.floats(0.01, 5.0),
    origin=st.floats(-1e6, 1e6),
    masses=st.lists(st.integers(0, 5_000), min_size=2, max_size=8, unique=True),
)
def test_residuals_of_points_on_a_line_are_nothing_but_rounding(slope, origin, masses):
    points = [Point(0, round((origin + mass_g / slope) * 128), mass_g * 1000) for mass_g in masses]
    if len({one.counts_q7 for one in points}) < 2:
        return
    # A count is rounded to 1/128, and the line tilts by no more than that.
    bound_mg = 2 * 1000 * slope / 128 * max(len(points), 2)
    assert max(abs(one.off_mg) for one in residuals(points)) <= bound_mg


def test_residuals_are_those_of_least_squares():
    points = [point(g, off_counts=off) for g, off in ((0, 0), (1000, 40), (3000, -25), (5000, 10))]
    counts = np.array([one.counts_q7 / 128 for one in points])
    mass = np.array([one.mass_mg for one in points], float)
    slope, origin = np.polyfit(counts, mass, 1)
    assert line_through(points) == pytest.approx((slope, origin), rel=1e-9)
    off = [one.off_mg for one in residuals(points)]
    assert off == pytest.approx(list(mass - (origin + slope * counts)), abs=1e-3)
    assert abs(sum(off)) < 1e-3


def test_points_that_leave_most_to_extrapolation_are_warned_about():
    assert reach_warning([point(0), point(2500)], 5_000_000, E_MG) == ""
    assert "4% of Max" in reach_warning([point(0), point(200)], 5_000_000, E_MG)


def test_the_check_weighing_is_suggested_where_the_points_are_farthest_apart():
    assert check_mass_mg([point(g) for g in (5000, 0, 1000)]) == 3_000_000
