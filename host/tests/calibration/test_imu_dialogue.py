# SPDX-License-Identifier: MIT
"""The IMU's calibration as a conversation, in lock step with the test double."""

from functools import cache

import numpy as np
import pytest

from host.tests.calibration.imu_bench import EVERY, MODE, bench_of, fill_line, sitting
from host.tests.fake_bench import Bench, Script
from terazi.applications.attitude.calibrated import setting_names
from terazi.calibration.imu.dialogue import Plan, calibrate_imu
from terazi.calibration.imu.rehearsal import FACES, Board, unit
from terazi.errors import Aborted, CalibrationRefused, NoAnswer
from terazi.link.generated.settings import SETTINGS_BY_NAME

KEYS = {
    name: SETTINGS_BY_NAME[name].key
    for group in ("acc", "gyro", "mag")
    for name in setting_names(group)
}


@cache
def whole():
    return sitting()


@cache
def faces_only():
    return sitting(2, FACES)


def held(bench):
    """What the board measures by now."""
    return {name: bench.chain.values[key] for name, key in KEYS.items()}


def is_untouched(bench):
    return (
        not any(held(bench).values())
        and bench.eeprom.sequence == 0
        and (bench.chain.values[MODE], bench.chain.values[EVERY]) == (1, 5)
    )


def converse(bench, *answers, **plan):
    script = Script(*answers)
    outcome = calibrate_imu(bench.link, script, Plan(**plan))
    assert not script.answers, "the conversation ended before the script"
    return outcome, script


def test_lying_still_on_its_sides_calibrates_a_board_and_it_keeps_that():
    bench = bench_of(whole())
    outcome, script = converse(bench, "save")
    assert outcome.settings_saved == 1
    assert held(bench) == held(bench) | outcome.settings
    assert bench.eeprom.values[KEYS["acc.xx_q16"]] == outcome.settings["acc.xx_q16"] != 0
    assert bench.eeprom.values[EVERY] == 5  # what only the calibration wanted is not saved
    offset_g = np.array(outcome.motion.acc.constants.offset_counts) / 2048
    assert np.abs(offset_g - Board(1, rate_hz=500.0).acc_offset_g).max() < 0.001
    assert outcome.motion.gyro.is_matrix_known
    assert "Missing: x up, x down, y up, y down, z up, z down." in script.said
    assert "z up: taken" in script.said
    assert "z down: as it lay for “z up”, but upside down." in script.text
    assert "The six are there. Now lean it at a slant" in script.text
    assert any("lies still, 1.5 of 2.5 s" in live for live in script.lives)
    assert any("moves by" in live for live in script.lives)
    assert "gravity off, before" in script.text
    assert script.said[-1] == "The calibration holds; saved, and read back."


def test_whoever_does_not_want_it_keeps_the_old_one():
    bench = bench_of(whole())
    outcome, _script = converse(bench, "leave")
    assert outcome.settings_saved is None
    assert is_untouched(bench)


def test_a_dry_run_shows_what_would_be_set_and_sets_nothing():
    bench = bench_of(whole())
    outcome, script = converse(bench, dry_run=True, asks=False)
    assert f"acc.xx_q16={outcome.settings['acc.xx_q16']}" in script.said
    assert is_untouched(bench)


def test_nobody_need_be_asked():
    bench = bench_of(whole())
    outcome, script = converse(bench, asks=False)
    assert not script.asked
    assert outcome.settings_saved == 1


def test_the_six_alone_will_do_where_slants_are_not_wanted():
    bench = bench_of(faces_only())
    outcome, script = converse(bench, asks=False, slants=False)
    assert len(outcome.motion.positions) == 6
    assert "Cross axes are known to" in script.text


def test_who_takes_no_slants_is_asked_and_may_go_on():
    bench = bench_of(faces_only())
    _outcome, script = converse(bench, "wait", "fit", "save", wait_s=8.0)
    assert script.asked[0] == "What now? wait | fit | abort"


def test_slants_that_never_come_are_done_without_where_nobody_is_asked():
    bench = bench_of(faces_only())
    outcome, _script = converse(bench, asks=False, wait_s=8.0)
    assert outcome.settings_saved == 1


def test_a_side_that_never_comes_is_named():
    bench = bench_of(sitting(1, FACES[:4]))
    with pytest.raises(CalibrationRefused, match="within 8 s; missing: y up, y down") as caught:
        converse(bench, asks=False, wait_s=8.0)
    assert "--wait" in caught.value.remedy
    assert is_untouched(bench)


def test_twelve_positions_of_any_kind_for_what_has_no_sides():
    rng = np.random.default_rng(4)
    ups = [
        (s * a, t * b, c)
        for s in (1, -1)
        for t in (1, -1)
        for a, b, c in ((0.3, 0.9, 0.3), (0.9, 0.3, -0.4), (0.3, 0.3, 0.9 * s * t))
    ]
    ups = [unit(np.array(up) + rng.normal(0, 0.02, 3)) for up in ups]
    bench = bench_of(sitting(3, ups))
    outcome, script = converse(bench, asks=False, free=True)
    assert len(outcome.motion.positions) >= 12
    assert "Missing: 11 more, such as" in script.text


@pytest.mark.parametrize("end", ["abort", "ctrl-C"])
def test_whatever_ends_it_early_leaves_the_board_as_it_was(end):
    bench = bench_of(sitting(1, FACES[:2]))

    def interrupt():
        raise KeyboardInterrupt

    answer, raises = ("abort", Aborted) if end == "abort" else (interrupt, KeyboardInterrupt)
    with pytest.raises(raises):
        converse(bench, answer, wait_s=6.0)
    assert is_untouched(bench)


def test_a_position_that_contradicts_is_taken_once_more():
    record = sitting(
        5, (*FACES, (1, 1, 0), (1, -1, 0), (0, 1, 1), (0, 1, -1), (1, 0, 1), (-1, 0, 1), (-1, 0, 1))
    )
    acc = record.acc_b_counts
    first = 6 * 5 * 500  # the first slant: 3 s of it, at most
    acc[first : first + 1500] += np.array((40, 40, 0), np.int16)  # 28 mg, while it lies
    bench = bench_of(record)
    script = Script("replace", "abort")
    with pytest.raises(Aborted):
        calibrate_imu(bench.link, script, Plan(wait_s=6.0))
    assert "The positions contradict one another" in script.text
    assert "at “x and y at a slant”" in script.text
    assert "Missing: x and y (1 more)." in script.said
    assert is_untouched(bench)


def test_a_board_without_an_imu_is_told_how_to_wire_one():
    bench = Bench()
    with pytest.raises(CalibrationRefused, match="has no IMU") as caught:
        converse(bench, asks=False)
    assert "SDA at A4" in caught.value.remedy


def test_a_line_that_is_full_of_attitudes_is_no_hindrance():
    bench = fill_line(bench_of(whole()))
    outcome, _script = converse(bench, asks=False)
    assert outcome.settings_saved == 1
    assert bench.chain.values[EVERY] == 1


def test_an_imu_that_falls_silent_is_told():
    bench = bench_of(sitting(1, FACES[:2]), ends=True)
    with pytest.raises(NoAnswer, match="sends no IMU samples any more"):
        converse(bench, asks=False)
    assert is_untouched(bench)


# The magnetometer.


def fields(count=4000):
    """Fields of a board that is turned about all axes, slowly."""
    rng = np.random.default_rng(3)
    t = np.linspace(0, 1, count)
    z = np.cos(np.pi * t)
    level = np.sqrt(1 - z * z)
    spiral = np.column_stack([level * np.cos(90 * t), level * np.sin(90 * t), z])
    soft = np.array([[1.05, 0.03, 0], [0.03, 0.97, -0.02], [0, -0.02, 1.0]])
    raw = 1400 * spiral @ soft + (300, -500, 120) + rng.normal(0, 4, (count, 3))
    return np.rint(raw).astype(int).tolist()


def test_turning_it_about_calibrates_the_magnetometer():
    bench = bench_of(whole(), fields=fields())
    outcome, script = converse(bench, asks=False, motion=False, field=True)
    assert outcome.settings_saved == 1
    offset = [outcome.settings[f"mag.offset_q3_{at}"] / 8 for at in range(3)]
    assert np.abs(outcome.field.mag.constants.offset_counts - (300, -500, 120)).max() < 5
    assert max(map(abs, offset)) > 100
    assert outcome.field.rms_after < 0.005 < 0.1 < outcome.field.rms_before
    assert any("of all directions seen" in live for live in script.lives)
    assert not any(name.startswith("acc.") for name in outcome.settings)


def test_a_board_without_a_magnetometer_is_told():
    bench = bench_of(whole())
    with pytest.raises(CalibrationRefused, match="has no magnetometer"):
        converse(bench, asks=False, motion=False, field=True)
    assert is_untouched(bench)


def test_what_looks_covered_about_a_wrong_middle_is_turned_on_with():
    early = fields(24_000)  # so slow that a cap of it stands for all about its own middle
    bench = bench_of(whole(), fields=early)
    outcome, _script = converse(bench, asks=False, motion=False, field=True, wait_s=15.0)
    assert np.abs(outcome.field.mag.constants.offset_counts - (300, -500, 120)).max() < 10


def test_a_field_seen_from_one_side_only_wants_more():
    bench = bench_of(whole(), fields=fields()[:2000])
    with pytest.raises(CalibrationRefused, match="of all directions only") as caught:
        converse(bench, asks=False, motion=False, field=True, wait_s=5.0)
    assert "Turn it slowly" in caught.value.remedy
