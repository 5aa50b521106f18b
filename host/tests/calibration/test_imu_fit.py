# SPDX-License-Identifier: MIT
"""Constants of simulated boards with known errors, recovered as the device's integers hold them."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from terazi.applications.attitude.calibrated import measured, nothing_set, setting_names
from terazi.calibration.imu import positions, standstill
from terazi.calibration.imu.fit import Contradiction, fit_field, fit_motion
from terazi.calibration.imu.gyroscope import carried
from terazi.calibration.imu.quantise import Constants, settings_of
from terazi.calibration.imu.rehearsal import FACES, ONE_G, SLANTS, Board, counts, held, unit
from terazi.errors import CalibrationRefused
from terazi.link.generated.settings import SETTINGS_BY_NAME

FACTORY = nothing_set("acc") | nothing_set("gyro")
SEEDS = range(1, 5)


def fitted(board, ups=(*FACES, *SLANTS), *, free=False, before=FACTORY, **sitting):
    record = board.sitting(list(ups), **sitting)
    return fit_motion(record, stills_of(record), before, free=free)


@cache
def usual(seed):
    """A board that lay on its faces and slants, and what came of it."""
    board = Board(seed)
    return board, fitted(board)


def stills_of(record):
    return standstill.find(record.acc_b_counts, record.gyro_b_counts, record.rate_hz)


@pytest.mark.parametrize("seed", SEEDS)
def test_offset_is_recovered_within_1_mg_and_scale_within_a_thousandth(seed):
    board, result = usual(seed)
    matrix, offset = held("acc", result.settings)
    truth, _turn = board.truth
    assert np.abs(offset / ONE_G - board.acc_offset_g).max() < 0.001
    assert np.abs(np.diag(matrix) / np.diag(truth) - 1).max() < 0.001
    assert np.abs(matrix - truth).max() < 0.002  # cross axes: 0.1 deg
    assert result.rms_g("before_g") > 0.05
    assert result.rms_g("after_g") < 0.0005
    assert not result.notes


@pytest.mark.parametrize("seed", SEEDS)
def test_the_gyroscopes_matrix_and_bias_come_of_the_turns(seed):
    board, result = usual(seed)
    matrix, offset = held("gyro", result.settings)
    assert result.gyro.is_matrix_known
    assert np.abs(matrix - board.gyro_truth).max() < 0.002
    assert np.abs(offset / 16.384 - board.bias_deg_s).max() < 0.02
    assert np.abs(result.bias_before_deg_s).min() > 19
    assert np.abs(result.bias_after_deg_s).max() < 0.04  # half a count of rounding is 0.03
    assert result.turns_after_deg < 0.1 < result.turns_before_deg / 20


@pytest.mark.parametrize("seed", SEEDS)
def test_twelve_positions_of_any_kind_do_as_well(seed):
    board = Board(seed)
    golden = (1 + 5**0.5) / 2  # an icosahedron's corners: none is a face
    turned = [(0, s, t * golden) for s in (1, -1) for t in (1, -1)]
    ups = [np.roll(each, by) for each in turned for by in range(3)]
    result = fitted(board, ups, free=True, tilt_deg=8.0)
    matrix, offset = held("acc", result.settings)
    assert np.abs(offset / ONE_G - board.acc_offset_g).max() < 0.001
    assert np.abs(np.diag(matrix) / np.diag(board.truth[0]) - 1).max() < 0.001


def test_six_faces_alone_leave_the_cross_axes_open_and_say_so():
    board = Board(3)
    result = fitted(board, FACES, tilt_deg=1.0)
    matrix, offset = held("acc", result.settings)
    assert np.abs(offset / ONE_G - board.acc_offset_g).max() < 0.002
    assert np.abs(np.diag(matrix) / np.diag(board.truth[0]) - 1).max() < 0.002
    assert any("cross axes are known to" in note and "x and y" in note for note in result.notes)


def test_what_the_board_held_before_is_what_its_residuals_are_before():
    board, first = usual(4)
    again = fitted(board, before=first.settings)
    assert again.rms_g("before_g") < 0.0006
    assert np.abs(again.bias_before_deg_s).max() < 0.04


@pytest.mark.parametrize("group", ["acc", "gyro", "mag"])
def test_settings_have_the_places_that_the_device_gives_them(group):
    keys = [SETTINGS_BY_NAME[name].key for name in setting_names(group)]
    assert keys == sorted(keys)
    rng = np.random.default_rng(5)
    matrix = np.eye(3) + rng.uniform(-0.03, 0.03, (3, 3))
    if group == "acc":
        matrix = np.tril(matrix)
    constants = Constants(matrix, rng.uniform(-150, 150, 3))
    raw = rng.integers(-20000, 20000, (400, 3)).astype(np.int16)
    made = measured(group, settings_of(group, constants), raw)
    # Half a count, a sixteenth of Q3's offset, and D's rounding at full scale.
    assert np.abs(made - constants.apply(raw)).max() < 0.5 + 1 / 16 + 3 * 20000 / 2**17


def test_constants_beyond_the_device_are_refused():
    with pytest.raises(CalibrationRefused, match="off by 60%: more than"):
        settings_of("gyro", Constants(np.diag([1.6, 1, 1]), np.zeros(3)))
    with pytest.raises(CalibrationRefused, match="offset of 4100 counts"):
        settings_of("mag", Constants(np.eye(3), np.array([4100.0, 0, 0])))


@pytest.mark.parametrize("left_out", range(6))
def test_a_missing_face_is_named_with_how_to_get_there(left_out):
    ups = [face for at, face in enumerate(FACES) if at != left_out]
    with pytest.raises(CalibrationRefused, match="of the six positions") as caught:
        fitted(Board(2), [*ups, *SLANTS])
    axis = "xyz"[int(np.argmax(np.abs(FACES[left_out])))]
    way = "up" if sum(FACES[left_out]) > 0 else "down"
    assert f"of the six positions {axis} {way} is missing" in str(caught.value)
    other = "down" if way == "up" else "up"
    assert f"as it lay for “{axis} {other}”, but upside down" in caught.value.remedy


def test_a_part_of_another_scale_is_refused():
    board = Board(1, offset_g=0.0)
    board.acc_k = board.acc_k * 2
    with pytest.raises(CalibrationRefused, match=r"measures 1\.94 g: another scale") as caught:
        fitted(board)
    assert "+-16 g" in caught.value.remedy


def test_a_position_that_was_held_askew_by_something_contradicts_the_others():
    board = Board(6)
    record = board.sitting([*FACES, *SLANTS])
    stills = stills_of(record)
    more = np.array((0, 60, 60))  # 40 mg
    held_up = dataclasses.replace(stills[8], acc_counts=stills[8].acc_counts + more)
    moved = [*stills[:8], held_up, *stills[9:]]
    with pytest.raises(Contradiction, match=r"off by \+4\d\.\d mg at “y and z") as caught:
        fit_motion(record, moved, FACTORY)
    assert caught.value.worst == 8
    fit_motion(record, [*moved[:8], *moved[9:]], FACTORY)


def test_twelve_positions_that_lie_in_one_plane_are_degenerate():
    angles = np.radians(np.arange(0, 360, 24))
    ups = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    with pytest.raises(CalibrationRefused, match="they lie too much alike"):
        fitted(Board(1), ups, free=True, tilt_deg=0.0)


def test_too_few_positions_of_any_kind_name_the_emptiest_direction():
    ups = [unit(up) for up in FACES if tuple(up) != (0, 0, -1)]
    with pytest.raises(CalibrationRefused, match="5 positions that differ are too few") as caught:
        fitted(Board(1), ups, free=True)
    assert "z" in caught.value.remedy


def test_a_bias_that_is_a_turn_is_refused():
    with pytest.raises(CalibrationRefused, match="turns by 60 deg/s"):
        fitted(Board(1, bias_deg_s=60.0))


def test_a_bias_that_changes_between_standstills_is_refused():
    board = Board(1)
    record = board.sitting([*FACES, *SLANTS])
    warm = np.rint(np.linspace(0, 40, len(record))).astype(np.int16)[:, None]
    record = dataclasses.replace(record, gyro_b_counts=record.gyro_b_counts + warm)
    with pytest.raises(CalibrationRefused, match=r"bias moves by 2\.\d deg/s") as caught:
        fit_motion(record, stills_of(record), FACTORY)
    assert "ten minutes" in caught.value.remedy


def test_turns_with_a_lost_sample_do_not_count():
    board = Board(1)
    record = board.sitting([*FACES, *SLANTS])
    stills = stills_of(record)
    number = record.number.copy()
    for one in stills[:8]:
        number[one.last + 50 :] += 1
    result = fit_motion(dataclasses.replace(record, number=number), stills, FACTORY)
    assert not result.gyro.is_matrix_known
    assert any("only 3 turns are of use" in note for note in result.notes)
    assert result.settings["gyro.xx_q16"] == 0
    assert result.settings["gyro.offset_q3_0"] != 0


def test_a_board_that_lay_for_a_minute_is_turned_no_longer_than_it_was():
    board = Board(1)
    record = board.sitting([*FACES, *SLANTS])
    first = stills_of(record)[0]
    again = np.tile(np.arange(first.first, first.last), 30)  # more than LONGEST_S of its first
    rows = np.concatenate([again, np.arange(len(record))])
    longer = dataclasses.replace(
        record,
        number=np.arange(len(rows)),
        acc_b_counts=record.acc_b_counts[rows],
        gyro_b_counts=record.gyro_b_counts[rows],
    )
    stills = stills_of(longer)
    assert stills[0].last < len(again) / 4 < len(again) < stills[0].end
    assert fit_motion(longer, stills, FACTORY).gyro.turns == 11


def test_a_hand_is_never_still():
    board = Board(1)
    rng = np.random.default_rng(8)
    n = 4000
    slow = np.cumsum(rng.normal(0, 0.003, (n, 3)), axis=0)
    record = board.record(np.array((0, 0, 1.0)) + rng.normal(0, 0.03, (n, 3)), slow)
    assert stills_of(record) == []


def test_a_direction_is_carried_as_a_body_turns():
    n, seconds = 200, 2.0
    rate = np.tile((0.0, 0.0, np.pi / 4), (n + 1, 1))  # 90 deg about z in 2 s
    then = carried(np.array((1.0, 0, 0)), rate, seconds / n)
    assert then == pytest.approx((0, -1, 0), abs=1e-9)  # x of the world is now -y of the body


@pytest.mark.parametrize(
    ("up", "name"),
    [((0, 0, 1), "z up"), ((-1, 0.1, 0), "x down"), ((1, 1, 0), "x and y at a slant")],
)
def test_positions_have_names(up, name):
    assert positions.name_of(unit(up)) == name


# The magnetometer.


def field_around(seed=1, *, n=3000, soft=0.08, hard=(400.0, -900.0, 250.0), tall=1.0, noise=3.0):
    """(raw counts, K, offset) of a field of 1500 counts from everywhere, K symmetric, det 1."""
    rng = np.random.default_rng(seed)
    units = rng.normal(size=(n, 3))
    units[:, 2] = np.abs(units[:, 2]) if tall == 0 else units[:, 2]
    units /= np.linalg.norm(units, axis=1)[:, None]
    k = rng.uniform(-soft, soft, (3, 3))
    k = np.eye(3) + (k + k.T) / 2
    k /= np.cbrt(np.linalg.det(k))
    raw = 1500 * units @ k.T + hard + rng.normal(0, noise, (n, 3))
    return counts(raw), k, np.array(hard)


@pytest.mark.parametrize("seed", SEEDS)
def test_hard_and_soft_iron_are_recovered(seed):
    raw, k, hard = field_around(seed)
    result = fit_field(raw, nothing_set("mag"))
    matrix, offset = held("mag", result.settings)
    assert np.abs(offset - hard).max() < 1.5  # a thousandth of the field
    assert np.abs(matrix - np.linalg.inv(k)).max() < 0.001
    assert result.mag.field_counts == pytest.approx(1500, rel=0.001)
    assert result.rms_before > 0.1
    assert result.rms_after < 0.003


def test_a_disturbance_on_the_way_is_left_out():
    raw, k, _hard = field_around(2)
    raw[100:180] += np.array((700, 0, 0), np.int16)
    result = fit_field(raw, nothing_set("mag"))
    matrix, _offset = held("mag", result.settings)
    assert np.abs(matrix - np.linalg.inv(k)).max() < 0.01
    assert "disturbed field" in result.notes[0]


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"n": 40}, "are too few"),
        ({"tall": 0}, "of all directions only"),
        ({"hard": (32000.0, 0, 0)}, "at its rail"),
        ({"hard": (6000.0, 0, 0)}, "more than the 4095"),
    ],
)
def test_a_field_that_tells_too_little_is_refused(how, said):
    raw, _k, _hard = field_around(**how)
    with pytest.raises(CalibrationRefused, match=said) as caught:
        fit_field(raw, nothing_set("mag"))
    assert caught.value.remedy


def test_turning_it_about_one_axis_only_is_refused():
    rng = np.random.default_rng(1)
    angle = np.linspace(0, 20, 2000)
    level = np.column_stack([np.cos(angle), np.sin(angle), np.full(2000, -0.5)])
    raw = counts(1500 * level + rng.normal(0, 3, (2000, 3)))
    with pytest.raises(CalibrationRefused, match=r"directions only|no ellipsoid"):
        fit_field(raw, nothing_set("mag"))
