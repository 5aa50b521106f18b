# SPDX-License-Identifier: MIT
"""The promised accuracy on the recordings of TERAZI_DATA, one setting for all of them."""

import os
from pathlib import Path

import pytest

from terazi.applications.walks import (
    NAVIGATORS,
    Options,
    estimate,
    find_walks,
    load_walk,
    path_errors,
    score,
)


@pytest.fixture(scope="module")
def data():
    folder = os.environ.get("TERAZI_DATA")
    if folder is None:
        pytest.skip("TERAZI_DATA is unset: no recorded walks to score")
    return Path(folder) / "walks"


def scored(folder, begins="", **options):
    walks = [load_walk(path) for path in find_walks(folder) if path.stem.startswith(begins)]
    return score(walks, lambda walk: estimate(walk, Options(**options)).path.pos_w_m).mean


def test_walks_under_cameras_stay_within_8_cm_and_causally_within_15(data):
    assert scored(data / "vicon").rmse_2d_m <= 0.08
    assert scored(data / "vicon", causal=True).rmse_2d_m <= 0.15


def test_stairs_and_crawling_stay_within_45_cm_in_space(data):
    assert scored(data / "vicon", "2018").rmse_3d_m <= 0.45
    assert scored(data / "vicon", "2018", causal=True).rmse_3d_m <= 0.45


def test_footprints_are_met_within_half_a_metre(data):
    assert scored(data / "footprints").rmse_2d_m <= 0.5


def test_the_short_walk_closes_within_10_cm_in_space(data):
    assert scored(data / "xio_gait").closure_m <= 0.10


@pytest.mark.parametrize("navigator", NAVIGATORS)
def test_drift_elimination_makes_no_recorded_walk_worse(data, navigator):
    for path in find_walks(data / "footprints") + find_walks(data / "vicon"):
        walk = load_walk(path)
        without, with_ = (
            path_errors(walk, estimate(walk, options).path.pos_w_m).rmse_2d_m
            for options in (
                Options(navigator=navigator),
                Options(navigator=navigator, eliminate_drift=True),
            )
        )
        assert with_ <= without + 0.01, path.stem
