# SPDX-License-Identifier: MIT
"""Errors of an attitude: known rotations, and laws for all of them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from terazi.applications.attitude.score import Errors, Score, attitude_errors

UP, EAST, NORTH = (0, 0, 1), (1, 0, 0), (0, 1, 0)


def turn(axis, deg):
    """A quaternion: so many degrees about a world axis."""
    half = np.radians(deg) / 2
    return np.array([np.cos(half), *(np.sin(half) * np.array(axis, dtype=float))])


def multiply(a, b):
    """(n, 4) products, scalar first."""
    a, b = np.atleast_2d(a), np.atleast_2d(b)
    w = a[:, 0] * b[:, 0] - np.sum(a[:, 1:] * b[:, 1:], axis=1)
    v = a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + np.cross(a[:, 1:], b[:, 1:])
    return np.column_stack([w, v])


units = (
    arrays(np.float64, (12, 4), elements=st.floats(-1, 1, width=32))
    .filter(lambda quats: np.linalg.norm(quats, axis=1).min() > 0.1)
    .map(lambda quats: quats / np.linalg.norm(quats, axis=1)[:, None])
)


def of(error, *, free=False, seed=3):
    """Errors of truths at random, turned by `error` in the world."""
    rng = np.random.default_rng(seed)
    truth = rng.normal(size=(50, 4))
    truth /= np.linalg.norm(truth, axis=1)[:, None]
    return attitude_errors(multiply(error, truth), truth, heading_is_free=free)


def near(inclination, heading, total):
    return Errors(*(pytest.approx(each, abs=1e-6) for each in (inclination, heading, total)))


def test_no_error_is_none():
    assert of(turn(UP, 0)) == near(0, 0, 0)
    assert of(-turn(UP, 0)) == near(0, 0, 0)


def test_a_turn_about_the_vertical_is_heading_alone():
    assert of(turn(UP, -25)) == near(0, 25, 25)
    assert of(turn(UP, 190)) == near(0, 170, 170)


def test_a_turn_about_a_level_axis_is_inclination_alone():
    assert of(turn(EAST, 2)) == near(2, 0, 2)
    assert of(turn(NORTH, -120)) == near(120, 0, 120)


def test_heading_and_inclination_make_the_total():
    """cos(total / 2) = cos(heading / 2) cos(inclination / 2)."""
    total = 2 * np.degrees(np.arccos(np.cos(np.radians(15)) * np.cos(np.radians(5))))
    assert of(multiply(turn(UP, 30), turn(EAST, 10))) == near(10, 30, total)


def test_a_figure_is_a_root_of_a_mean_square():
    truth = np.tile(turn(UP, 0), (2, 1))
    found = attitude_errors(np.array([turn(EAST, 3), turn(EAST, 4)]), truth, heading_is_free=False)
    assert found == near(np.sqrt(12.5), 0, np.sqrt(12.5))


def test_free_heading_takes_a_constant_off_and_leaves_its_drift():
    truth = np.tile(turn(NORTH, 70), (3, 1))
    drifting = np.vstack([multiply(turn(UP, 100 + deg), truth[:1]) for deg in (-6, 0, 6)])
    found = attitude_errors(drifting, truth, heading_is_free=True)
    assert found == near(0, np.sqrt(24), np.sqrt(24))


@given(estimate=units, truth=units, deg=st.floats(-180, 180))
def test_free_heading_does_not_know_north(estimate, truth, deg):
    turned = multiply(np.tile(turn(UP, deg), (12, 1)), estimate)
    a = attitude_errors(estimate, truth, heading_is_free=True)
    b = attitude_errors(turned, truth, heading_is_free=True)
    fixed = attitude_errors(estimate, truth, heading_is_free=False)
    assert b.inclination_rmse_deg == pytest.approx(a.inclination_rmse_deg, abs=1e-5)
    assert a.inclination_rmse_deg == pytest.approx(fixed.inclination_rmse_deg, abs=1e-5)


@given(estimate=units, truth=units, free=st.booleans())
def test_total_is_the_largest_and_signs_do_not_matter(estimate, truth, free):
    found = attitude_errors(estimate, truth, heading_is_free=free)
    assert 0 <= found.inclination_rmse_deg <= found.total_rmse_deg + 1e-9
    assert 0 <= found.heading_rmse_deg <= found.total_rmse_deg + 1e-9 <= 180 + 1e-8
    flipped = attitude_errors(-estimate, truth, heading_is_free=free)
    assert flipped.total_rmse_deg == pytest.approx(found.total_rmse_deg, abs=1e-9)


@given(estimate=units, truth=units)
def test_free_heading_takes_off_the_turn_that_fits_best(estimate, truth):
    """No other constant turn makes the mean square of sin(total / 2) smaller."""

    def mean_square(deg):
        parts = multiply(np.tile(turn(UP, deg), (12, 1)), estimate)
        return np.mean(1 - np.sum(parts * truth, axis=1) ** 2)

    from terazi.applications.attitude.score import error_quaternions, without_heading_offset

    best = np.mean(1 - without_heading_offset(error_quaternions(estimate, truth))[:, 0] ** 2)
    assert best <= min(mean_square(deg) for deg in range(-180, 180, 5)) + 1e-9


def test_mean_and_worst_are_of_each_figure():
    score = Score({"a": Errors(1.0, 5.0, 6.0), "b": Errors(3.0, 1.0, 4.0)})
    assert score.mean == Errors(2.0, 3.0, 5.0)
    assert score.worst == Errors(3.0, 5.0, 6.0)
    assert list(score.plain()) == ["trials", "mean", "worst"]
    keys = ["inclination_rmse_deg", "heading_rmse_deg", "total_rmse_deg"]
    for row in (*score.plain()["trials"].values(), score.plain()["mean"], score.plain()["worst"]):
        assert list(row) == keys
