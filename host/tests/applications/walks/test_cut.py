# SPDX-License-Identifier: MIT
"""What is cut off a record's end changes nothing of a causal path, and of a recorded one no
position by more than a centimetre, be it in mid-swing."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from terazi.applications.walks import (
    ALL_DETECTORS,
    NAVIGATORS,
    Options,
    estimate,
    find_walks,
    load_walk,
)
from terazi.applications.walks import simulator as of
from terazi.applications.walks.detectors import Detection
from terazi.applications.walks.navigator import KalmanSettings, glided, held, kalman
from terazi.cshared import Ins

pytestmark = pytest.mark.no_cover  # hundreds of paths, which other tests walk too

MOST_M = 0.01
LATEST_S = 1.2  # of the end that is not settled
CUTS = 10
CUTS_OF_RECORDED = 10 if "TERAZI_LONG" in os.environ else 2
HELD_DETECTORS = [name for name in ALL_DETECTORS if name not in ("device", "low_pass")]


def routes():
    """Walks that differ: strides of varied length and time, runs, stairs, turns, no standstill."""
    rng = np.random.default_rng(3)
    varied = of.strides(12, rng=rng) + of.turning(2.0) + of.strides(8, of.RUNNING, rng=rng)
    return {
        "varied": [*of.stand(1.5), *varied, *of.stand(1.0)],
        "runner": [*of.stand(1.0), *of.strides(20, of.RUNNING, rng=rng), *of.stand(1.0)],
        "stairs": [*of.stand(1.5), *of.staircase(10), *of.strides(6, rng=rng)],
        "unrested": [*of.stand(0.2), *of.strides(15, rng=rng), *of.stand(0.5)],
    }


NARROW = replace(of.Mems(), gyro_range_rad_s=8.0)  # a runner's foot turns faster
NARROWLY = ["varied", "runner"]
WALKS = {
    name: of.simulate(route, seed=21, name=name, mems=NARROW if name in NARROWLY else None)
    for name, route in routes().items()
}
WHOLE = {}


def whole(name, options):
    """Its path, computed once."""
    key = name, options
    if key not in WHOLE:
        WHOLE[key] = estimate(WALKS[name], options).path
    return WHOLE[key]


def kept(walk, share):
    """How many samples are left: 2.5 s at least."""
    least = round(2.5 * walk.rate_hz)
    return least + round(share * (len(walk) - least))


def largest_change_m(walk, before, count, options):
    part = estimate(walk.cut(count), options).path
    change = np.linalg.norm(part.pos_w_m - before.pos_w_m[:count], axis=1)
    return part, float(change.max())


def test_peaks_that_are_put_back_are_among_what_is_cut():
    assert [name for name, walk in WALKS.items() if len(walk.rates.tops_rad_s)] == NARROWLY


@pytest.mark.parametrize("name", WALKS)
@given(share=st.floats(0.0, 1.0))
@settings(max_examples=20)
def test_no_position_moves_by_a_centimetre_whatever_is_cut_off(name, share):
    walk = WALKS[name]
    count = kept(walk, share)
    before = whole(name, Options())
    part, change_m = largest_change_m(walk, before, count, Options())
    assert change_m <= MOST_M
    assert count - part.settled < LATEST_S * walk.rate_hz
    assert np.array_equal(part.pos_w_m[: part.settled], before.pos_w_m[: part.settled])


@pytest.mark.parametrize("name", WALKS)
@given(share=st.floats(0.0, 1.0))
@settings(max_examples=20)
def test_a_causal_path_does_not_change_in_a_bit(name, share):
    walk = WALKS[name]
    count = kept(walk, share)
    before = whole(name, Options(causal=True))
    part, _ = largest_change_m(walk, before, count, Options(causal=True))
    for one, other in ((part.pos_w_m, before.pos_w_m), (part.quat_wb, before.quat_wb)):
        assert np.array_equal(one, other[:count])


@pytest.mark.parametrize("causal", [False, True], ids=["recorded", "causal"])
@pytest.mark.parametrize("navigator", NAVIGATORS)
@pytest.mark.parametrize("detector", HELD_DETECTORS)
def test_it_holds_for_every_detector_and_navigator(detector, navigator, causal):
    walk, options = WALKS["varied"], Options(detector, navigator, causal=causal)
    before = whole("varied", options)
    for count in np.random.default_rng(4).integers(500, len(walk), CUTS):
        _, change_m = largest_change_m(walk, before, int(count), options)
        assert change_m <= (0.0 if causal else MOST_M)


def test_a_causal_path_of_a_detector_that_knows_the_whole_record_does_not_change_either():
    options = Options("low_pass", causal=True)
    _, change_m = largest_change_m(WALKS["varied"], whole("varied", options), 2345, options)
    assert change_m == 0.0


def test_without_a_hold_a_landing_moves_its_swing():
    """That the hold has something to do: what the tests above would find without it."""
    free = Options(kalman=KalmanSettings(held_m=np.inf))
    walk, before = WALKS["runner"], whole("runner", free)
    changes = [
        largest_change_m(walk, before, count, free)[1] for count in range(600, len(walk), 97)
    ]
    assert max(changes) > 2 * MOST_M


def test_held_stays_where_it_may_and_stops_where_it_must():
    told = np.zeros((3, 3))
    known = np.array([[0.003, 0, 0], [0, 0.04, 0.03], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(held(told, known, 0.01), [[0.003, 0, 0], [0, 0.008, 0.006], [0] * 3])
    assert np.array_equal(held(told, known, np.inf), known)


def test_a_leap_is_glided_and_what_velocity_explains_is_left_alone():
    dt_s = np.full(400, 0.005)
    vel = np.column_stack([np.sin(np.arange(400) / 40), np.ones(400), np.zeros(400)])
    way = np.cumsum(np.vstack([np.zeros((1, 3)), (vel[1:] + vel[:-1]) / 2 * 0.005]), axis=0)
    np.testing.assert_allclose(glided(way, vel, dt_s), way, atol=1e-12)
    leaping = way + np.where(np.arange(400) >= 200, 1.0, 0.0)[:, None] * [0.1, 0.0, -0.2]
    found = glided(leaping, vel, dt_s)
    assert np.abs(np.diff(found - way, axis=0)).max() < 0.03
    np.testing.assert_allclose(found[200 + 140 :], leaping[200 + 140 :], atol=1e-6)
    assert np.array_equal(glided(leaping[:250], vel[:250], dt_s[:250]), found[:250])


@pytest.mark.parametrize("navigator", NAVIGATORS)
@pytest.mark.parametrize("causal", [False, True], ids=["recorded", "causal"])
def test_no_path_leaps(navigator, causal):
    """Not even where it learns better: it would look broken."""
    names = set(WALKS)
    if navigator == "complementary":
        names.remove("unrested")  # an attitude that is not known yet gives wild velocities
    for name in sorted(names):
        walk = WALKS[name]
        path = whole(name, Options(navigator=navigator, causal=causal))
        speed_m_s = np.linalg.norm(np.diff(path.pos_w_m, axis=0), axis=1) * walk.rate_hz
        true_m_s = np.linalg.norm(np.diff(walk.truth.pos_t_m, axis=0), axis=1) * walk.rate_hz
        assert speed_m_s.max() < 1.5 * true_m_s.max()


def decisions(still):
    return Detection(np.where(still, 0.5, 2.0), np.ones(len(still)), "")


def test_decisions_that_are_revised_make_the_path_of_the_better_ones():
    """At once one stance of three is missed; where that is known the path is as if never missed."""
    walk = of.simulate([*of.stand(2), *of.strides(12), *of.stand(3)], seed=2)
    late_s = 0.3
    known = replace(decisions(walk.zero_velocity), ahead_s=late_s)
    missed = walk.zero_velocity & (np.arange(len(walk)) // 220 % 3 > 0)
    settings_ = KalmanSettings()
    paths = {
        "never known": kalman(walk, decisions(missed), settings_, causal=True),
        "known later": kalman(
            walk, replace(known, at_once=decisions(missed)), settings_, causal=True
        ),
        "known at once": kalman(
            walk, replace(known, at_once=decisions(walk.zero_velocity)), settings_, causal=True
        ),
    }
    best = paths["known at once"].pos_w_m
    end = slice(len(walk) - 100, None)  # it stands there for long
    error_m = {name: np.abs(path.pos_w_m - best)[end].max() for name, path in paths.items()}
    assert 10 * error_m["known later"] < error_m["never known"]


def test_what_is_told_at_once_is_the_filter_s_where_nothing_is_revised():
    walk = WALKS["varied"]
    vel = np.where(walk.zero_velocity, 0.05, 0.0)
    none = np.zeros(len(walk))
    columns = walk.dt_s, walk.acc_b_m_s2

    def ins():
        return Ins(
            (1, 0, 0, 0),
            sigmas={"velocity": 0.1, "attitude": 0.02, "gyro_bias": 0.01},
            noises={"velocity": 0.05, "attitude": 0.01},
            gravity_m_s2=9.81,
        )

    same = (walk.gyro_b_rad_s, vel, none, none)
    plain, _ = ins().run(*columns, *same)
    told = ins().run_at_once(*columns, same, same, revised_after=60, piece=20)
    assert np.array_equal(told, plain)


@pytest.mark.parametrize("causal", [False, True], ids=["recorded", "causal"])
@pytest.mark.parametrize("navigator", NAVIGATORS)
def test_no_recorded_walk_s_path_moves_by_a_centimetre_whatever_is_cut_off(navigator, causal):
    if "TERAZI_DATA" not in os.environ:
        pytest.skip("TERAZI_DATA is unset: no recorded walks to cut")
    data = Path(os.environ["TERAZI_DATA"]) / "walks"
    rng, options = np.random.default_rng(6), Options(navigator=navigator, causal=causal)
    for path in sorted(each for folder in data.iterdir() for each in find_walks(folder)):
        walk = replace(load_walk(path), truth=None)
        before = estimate(walk, options).path
        for count in rng.integers(round(2.5 * walk.rate_hz), len(walk), CUTS_OF_RECORDED):
            part, change_m = largest_change_m(walk, before, int(count), options)
            assert change_m <= (0.0 if causal else MOST_M), (path.stem, count)
            assert navigator != "kalman" or count - part.settled < LATEST_S * walk.rate_hz
            same = np.array_equal(part.pos_w_m[: part.settled], before.pos_w_m[: part.settled])
            assert same, (path.stem, count)
