# SPDX-License-Identifier: MIT
"""A calibration on the device: begun, taken point by point, ended, saved; and all its refusals."""

import pytest

from terazi.errors import CommandRefused
from terazi.link.generated.messages import (
    CalibrateAbort,
    CalibrateBegin,
    CalibrateEnd,
    CalibrateKnown,
    CalibratePoint,
    GetPoint,
    Point,
    ResetSettings,
    ResetWhat,
    Result,
    SettingsState,
    Weight,
    WeightFlag,
)

pytestmark = pytest.mark.board(counts_per_gram=300.0, zero_counts=20_000.0, noise_counts=30.0)

SETTLE_S = 2.0
POINTS_MAX = 8


def weight_of(uno, grams):
    """What the device tells of a load that stands."""
    uno.load(grams=grams)
    uno.wait(SETTLE_S)
    return [one.message for one in uno.wait(0.3) if isinstance(one.message, Weight)][-1]


def take(uno, grams):
    uno.load(grams=grams)
    uno.wait(SETTLE_S)
    mass_mg = round(grams * 1000)
    return uno.link.ask(CalibratePoint(mass_mg), Point, mass_mg=mass_mg)


def known(uno, counts_q7, mass_mg):
    return uno.link.ask(CalibrateKnown(counts_q7, mass_mg), Point, mass_mg=mass_mg)


def points(uno):
    found = []
    while uno.link.request(GetPoint(len(found))).result == Result.OK:
        found.append(uno.link.ask(GetPoint(len(found)), Point, index=len(found)))
    return [(point.counts_q7, point.mass_mg) for point in found]


def calibrate(uno, *grams):
    uno.link.hello()
    uno.link.command(CalibrateBegin())
    for one in grams:
        take(uno, one)
    uno.link.command(CalibrateEnd())


@pytest.mark.parametrize("order", [(0.0, 2000.0), (2000.0, 0.0), (500.0, 2000.0, 0.0, 4000.0)])
def test_a_cell_is_calibrated_by_what_lies_on_it_and_weighs_right_at_once(uno, order):
    calibrate(uno, *order)
    assert [mass_mg for _counts, mass_mg in points(uno)] == sorted(1000 * g for g in order)
    for counts_q7, mass_mg in points(uno):
        assert abs(counts_q7 / 128 - (20_000 + 0.3 * mass_mg)) < 60
    for grams in (1000.0, 4000.0, 0.0, 2500.0):
        weight = weight_of(uno, grams)
        assert abs(weight.net_mg - 1000 * grams) < 500
        assert weight.weight_flags & WeightFlag.STABLE
        assert weight.calibrating == 0


def test_what_lies_there_at_the_end_of_a_calibration_is_not_taken_for_zero(uno):
    calibrate(uno, 0.0, 400.0)
    assert abs(weight_of(uno, 400.0).net_mg - 400_000) < 300


def test_a_calibration_is_saved_and_found_again_after_a_reset(uno):
    uno.truth("be reset in the middle of things")
    calibrate(uno, 0.0, 1500.0)
    before = points(uno)
    uno.wait(2.0)
    status = uno.link.status()
    assert (status.settings_state, status.settings_saved) == (SettingsState.IDLE, 1)
    uno.load(grams=0.0)
    uno.reset()
    uno.link.stream.hello = None
    uno.link.hello()
    assert points(uno) == before
    weight_of(uno, 0.0)
    assert abs(weight_of(uno, 3000.0).net_mg - 3_000_000) < 500


def test_points_come_in_any_order_and_a_second_of_one_mass_takes_the_firsts_place(uno):
    uno.link.hello()
    uno.link.command(CalibrateBegin())
    assert known(uno, 1_000_000, 100_000).index == 0
    assert known(uno, 9_000_000, 900_000).index == 1
    assert known(uno, 5_000_000, 500_000).index == 1
    assert known(uno, -4_000_000, -400_000).index == 0
    assert known(uno, 5_000_001, 500_000).index == 2
    assert points(uno) == [
        (-4_000_000, -400_000),
        (1_000_000, 100_000),
        (5_000_001, 500_000),
        (9_000_000, 900_000),
    ]
    assert weight_of(uno, 0.0).calibrating == 5


def test_eight_points_are_taken_and_a_ninth_is_not(uno):
    uno.link.hello()
    uno.link.command(CalibrateBegin())
    for at in range(POINTS_MAX):
        known(uno, at * 5_000_000, at * 500_000)
    assert uno.link.request(CalibrateKnown(1, 499_999)).result == Result.TOO_MANY_POINTS
    assert known(uno, 35_000_001, 3_500_000).index == 7
    uno.link.command(CalibrateEnd())
    assert points(uno)[:7] == [(at * 5_000_000, at * 500_000) for at in range(7)]
    assert points(uno)[7:] == [(35_000_001, 3_500_000)]


REFUSED_AT_THE_END = {
    "none": ([], Result.TOO_FEW_POINTS),
    "one": ([(0, 0)], Result.TOO_FEW_POINTS),
    "level": ([(5, 0), (5, 1000)], Result.NOT_MONOTONE),
    "turning": ([(0, 0), (9_000_000, 1000), (8_000_000, 2000)], Result.NOT_MONOTONE),
    "steep": ([(0, 0), (1000, 1001)], Result.TOO_STEEP),
}


@pytest.mark.parametrize(("taken", "result"), REFUSED_AT_THE_END.values(), ids=REFUSED_AT_THE_END)
def test_points_that_make_no_curve_are_refused_and_the_calibration_goes_on(uno, taken, result):
    uno.link.hello()
    old = points(uno)
    uno.link.command(CalibrateBegin())
    for counts_q7, mass_mg in taken:
        known(uno, counts_q7, mass_mg)
    before = points(uno)
    assert uno.link.request(CalibrateEnd()).result == result
    assert points(uno) == before, "what was taken stays"
    weight = weight_of(uno, 100.0)
    assert weight.calibrating == len(taken) + 1
    uno.link.command(CalibrateAbort())
    assert points(uno) == old


def test_an_aborted_calibration_leaves_no_trace(uno):
    calibrate(uno, 0.0, 2000.0)
    before, shown = points(uno), weight_of(uno, 700.0)
    uno.wait(1.0)
    saved = uno.link.status().settings_saved
    uno.link.command(CalibrateBegin())
    take(uno, 1000.0)
    known(uno, 7, 7_000_000)
    uno.link.command(CalibrateAbort())
    assert points(uno) == before
    assert abs(weight_of(uno, 700.0).net_mg - shown.net_mg) < 300
    assert uno.link.status().settings_saved == saved


def test_a_calibration_under_way_is_forgotten_by_a_reset(uno):
    uno.link.hello()
    old = points(uno)
    uno.link.command(CalibrateBegin())
    known(uno, 0, 0)
    uno.reset()
    uno.link.stream.hello = None
    uno.link.hello()
    with pytest.raises(CommandRefused):
        uno.link.command(CalibrateEnd())
    assert points(uno) == old


def test_factory_settings_spare_the_calibration_unless_everything_is_wanted(uno):
    calibrate(uno, 0.0, 2000.0)
    factory, mine = [(0, 0), (274_914_089, 5_000_000)], points(uno)
    uno.link.command(ResetSettings(ResetWhat.ALL_BUT_CALIBRATION))
    assert points(uno) == mine
    uno.link.command(ResetSettings(ResetWhat.EVERYTHING))
    assert points(uno) == factory
