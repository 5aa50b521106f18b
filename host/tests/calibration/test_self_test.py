# SPDX-License-Identifier: MIT
"""The part's self-test, judged by the datasheet's formulas."""

import pytest

from host.tests.calibration.imu_bench import EVERY, MODE, bench_of, sitting
from host.tests.fake_bench import Script
from terazi.calibration.imu.rehearsal import FACES
from terazi.calibration.imu.self_test import codes, judge, promised, self_test, want_all
from terazi.errors import CalibrationRefused

# Codes: accelerometer 13, 21, 6, gyroscope 17, 9, 30, as registers 0x0D to 0x10.
TRIM = (
    13 >> 2 << 5 | 17,
    21 >> 2 << 5 | 9,
    6 >> 2 << 5 | 30,
    (13 & 3) << 4 | (21 & 3) << 2 | 6 & 3,
)


def test_codes_are_put_together_as_the_register_map_has_them():
    assert codes(TRIM) == ([13, 21, 6], [17, 9, 30])
    assert codes((0xFF, 0, 0, 0x30)) == ([31, 0, 0], [31, 0, 0])


@pytest.mark.parametrize(
    ("sensor", "axis", "code", "counts"),
    [  # by hand from PS-MPU-6000A-00 rev 3.4, p. 12
        ("gyroscope", "x", 1, 3275.0),
        ("gyroscope", "y", 1, -3275.0),
        ("gyroscope", "z", 31, 3275.0 * 1.046**30),
        ("accelerometer", "y", 1, 1392.64),
        ("accelerometer", "z", 31, 4096 * 0.92),
        ("accelerometer", "x", 0, 0.0),
    ],
)
def test_a_code_promises_what_the_datasheet_says(sensor, axis, code, counts):
    assert promised(sensor, axis, code) == pytest.approx(counts)


def answers_of(trim, share=1.0):
    acc, gyro = codes(trim)
    return (
        [
            share * promised("accelerometer", axis, code)
            for axis, code in zip("xyz", acc, strict=True)
        ],
        [share * promised("gyroscope", axis, code) for axis, code in zip("xyz", gyro, strict=True)],
    )


@pytest.mark.parametrize(("share", "passes"), [(0.861, True), (1.139, True), (0.859, False)])
def test_fourteen_percent_are_allowed(share, passes):
    answers = judge(TRIM, *answers_of(TRIM, share))
    assert [one.passes for one in answers] == [passes] * 6


def test_an_axis_that_was_never_trimmed_passes():
    assert all(one.passes for one in judge((0, 0, 0, 0), (0, 5, 9000), (1, 2, -3)))


def run(**how):
    bench = bench_of(sitting(1, FACES[:1]), trim=TRIM, **how)
    script = Script()
    answers = self_test(bench.link, script)
    assert (bench.chain.values[MODE], bench.chain.values[EVERY]) == (1, 5)
    return answers, script


def test_a_good_part_passes_and_the_board_goes_on_as_before():
    answers, script = run(answers=answers_of(TRIM, 1.05))
    want_all(answers)
    for one in answers:
        assert one.off == pytest.approx(0.05, abs=0.01)
    assert script.text.count("passes") == 6


def test_an_axis_that_is_off_fails_by_its_name():
    acc, gyro = answers_of(TRIM)
    gyro[1] *= -1  # the wrong way
    answers, script = run(answers=(acc, gyro))
    assert script.text.count("FAILS") == 1
    with pytest.raises(CalibrationRefused, match=r"fails: gyroscope y \(-200%\)"):
        want_all(answers)


def test_a_board_that_moves_meanwhile_is_told():
    with pytest.raises(CalibrationRefused, match="the board moves"):
        run(answers=answers_of(TRIM), shakes=400)


def test_a_sibling_is_judged_with_a_warning():
    _answers, script = run(answers=answers_of(TRIM), identity=0x70)
    assert "WHO_AM_I is 0x70" in script.text
