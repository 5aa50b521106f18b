# SPDX-License-Identifier: MIT
"""Errors: Euclidean, with the heading free, as the definitions say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.applications.walks import Errors, Score, Truth, Walk, path_errors

PATH = np.cumsum(np.random.default_rng(3).normal(0, 0.1, (200, 3)), axis=0)


def walk_of(truth):
    return Walk("w", np.arange(200) / 200, np.zeros((200, 3)), np.zeros((200, 3)), truth)


def turned(path, angle):
    cos, sin = np.cos(angle), np.sin(angle)
    return path @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])


@given(angle=st.floats(-3.1, 3.1), x=st.floats(-9, 9), y=st.floats(-9, 9), z=st.floats(-9, 9))
def test_a_path_that_is_only_turned_and_shifted_has_no_error(angle, x, y, z):
    truth = Truth(np.arange(200), np.add(turned(PATH, angle), [x, y, z]))
    errors = path_errors(walk_of(truth), PATH)
    assert errors.rmse_2d_m < 1e-9
    assert errors.rmse_3d_m < 1e-9


def test_errors_are_euclidean_and_not_means_over_axes():
    truth = Truth(np.arange(200), PATH.copy())
    off = np.where(np.arange(200) % 2, 1.0, -1.0)[:, None] * [0.03, 0.04, 0.12]
    errors = path_errors(walk_of(truth), PATH + off)
    assert errors.rmse_2d_m == pytest.approx(0.05, rel=1e-3)
    assert errors.rmse_3d_m == pytest.approx(0.13, rel=1e-3)


def test_footprints_are_matched_at_their_first_point_alone():
    straight = np.zeros((200, 3))
    straight[:, 0] = np.linspace(0, 10, 200)
    at = np.array([0, 100, 199])
    truth = Truth(at, straight[at, :2] * 1.1, from_start=True)
    errors = path_errors(walk_of(truth), np.add(straight, [5.0, 5.0, 0]))
    expected = np.sqrt(np.mean((0.1 * straight[at, 0]) ** 2))
    assert errors.rmse_2d_m == pytest.approx(expected)
    assert errors.rmse_3d_m is None


def test_a_mirrored_path_cannot_hide_behind_the_free_heading():
    truth = Truth(np.arange(200), PATH * [1, -1, 1])
    assert path_errors(walk_of(truth), PATH).rmse_2d_m > 0.1


def test_closure_is_told_of_loops_and_where_nothing_is_known():
    angle = np.linspace(0, 2 * np.pi, 200)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(200)])
    drifted = ring + np.linspace(0, 1, 200)[:, None] * [0.3, 0.0, 0.4]
    assert path_errors(walk_of(Truth(np.arange(200), ring)), drifted).closure_m == pytest.approx(
        0.5
    )
    assert path_errors(walk_of(None), drifted) == Errors(None, None, pytest.approx(0.5))
    line = np.linspace(0, 5, 200)[:, None] * [1.0, 0, 0]
    assert path_errors(walk_of(Truth(np.arange(200), line)), line).closure_m is None


def test_means_leave_out_what_is_not_known():
    found = Score({"a": Errors(1.0, None, None), "b": Errors(3.0, 2.0, None)})
    assert found.mean == Errors(2.0, 2.0, None)
    assert found.plain() == {
        "trials": {
            "a": {"rmse_2d_m": 1.0, "rmse_3d_m": None, "closure_m": None},
            "b": {"rmse_2d_m": 3.0, "rmse_3d_m": 2.0, "closure_m": None},
        },
        "mean": {"rmse_2d_m": 2.0, "rmse_3d_m": 2.0, "closure_m": None},
    }
