# SPDX-License-Identifier: MIT
"""imu_cal.c: golden vectors, laws for all inputs, and parity with the float64 model."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from terazi.cshared import ImuCal, ImuTurn
from terazi.models import exact_imu
from terazi.models import imu_cal as model
from terazi.models.vectors import golden

LOW, HIGH = exact_imu.INT16_MIN, exact_imu.INT16_MAX
int16 = st.integers(LOW, HIGH)
vectors = st.tuples(int16, int16, int16)
IDENTITY = [[0] * 3] * 3


@st.composite
def lawful_rows(draw):
    """Three numbers whose magnitudes sum to at most ROW_MAX."""
    left, row = model.ROW_MAX, []
    for _ in range(3):
        magnitude = draw(st.integers(0, left))
        left -= magnitude
        row.append(draw(st.sampled_from((magnitude, -magnitude))))
    return draw(st.permutations(row))


slope = st.integers(-model.SLOPE_MAX, model.SLOPE_MAX)
slopes = st.tuples(slope, slope, slope)
configs = st.tuples(st.tuples(lawful_rows(), lawful_rows(), lawful_rows()), vectors)
orientations = st.sampled_from(sorted(model.ORIENTATIONS.values()))


def words(vector, name):
    return [int(word) for word in vector.parameters[name].split()]


def rows(vector, kind, unit="counts"):
    return list(zip(*(vector[f"{kind}_{axis}_{unit}"] for axis in "xyz"), strict=True))


@pytest.mark.parametrize("vector", golden("imu_cal_apply_"), ids=str)
def test_imu_cal_reproduces_vector_bit_for_bit(vector):
    cal = ImuCal(np.reshape(words(vector, "matrix_q16"), (3, 3)), words(vector, "offset_q3"))
    assert [cal.apply(raw) for raw in rows(vector, "raw")] == rows(vector, "true")
    assert cal.clipped == vector.parameter("clipped")


@pytest.mark.parametrize("vector", golden("imu_cal_temperature"), ids=str)
def test_imu_cal_offsets_follow_the_temperature_bit_for_bit(vector):
    cal = ImuCal(offset_q3=words(vector, "offset_q3"))
    for warmth, offset in zip(
        vector["above_reference_counts"], rows(vector, "offset", "q3"), strict=True
    ):
        cal.set_temperature(warmth, words(vector, "slope_q16"))
        assert cal.offset_q3 == offset


@pytest.mark.parametrize("vector", golden("imu_cal_turn"), ids=str)
def test_imu_cal_turns_as_the_vector_says_and_only_as_a_part_can_stand(vector):
    found = zip(vector["orientation"], rows(vector, "part"), rows(vector, "board"), strict=True)
    for orientation, part, board in found:
        assert ImuTurn(orientation).apply(part) == board
    assert set(vector["orientation"]) == set(model.ORIENTATIONS.values())
    for orientation in set(range(256)) - set(vector["orientation"]):
        with pytest.raises(ValueError, match="no orientation"):
            ImuTurn(orientation)


@given(config=configs, raws=st.lists(vectors, max_size=8))
@example(config=([[32767, 0, 0]] * 3, [LOW] * 3), raws=[(HIGH,) * 3])
@example(config=([[32767, 0, 0]] * 3, [HIGH] * 3), raws=[(LOW,) * 3])
@example(config=([[-32767, 0, 0]] * 3, [LOW] * 3), raws=[(LOW,) * 3])
def test_imu_cal_is_its_exact_twin_for_any_lawful_constants(config, raws):
    cal = ImuCal(*config)
    results, clipped = exact_imu.imu_cal(raws, *config)
    assert [cal.apply(raw) for raw in raws] == results
    assert cal.clipped == clipped


@given(config=configs, slope=slopes, warmth=int16, raws=st.lists(vectors, max_size=3))
def test_imu_cal_at_any_temperature_is_its_exact_twin(config, slope, warmth, raws):
    cal = ImuCal(*config)
    cal.set_temperature(HIGH, slope)  # each is from the reference, not from the one before
    cal.set_temperature(warmth, slope)
    matrix, offset = config
    offset = exact_imu.offset_at_temperature(offset, slope, warmth)
    assert [cal.apply(raw) for raw in raws] == exact_imu.imu_cal(raws, matrix, offset)[0]


@given(raw=vectors)
def test_imu_cal_without_constants_passes_everything_on(raw):
    cal = ImuCal()
    assert cal.apply(raw) == raw
    assert cal.clipped == any(value in (LOW, HIGH) for value in raw)


@given(config=configs, raw=vectors, axis=st.integers(0, 2), step=st.integers(0, 65535))
def test_imu_cal_result_never_falls_when_its_own_axis_rises(config, raw, axis, step):
    """Each diagonal element of M is at least 1/2."""
    higher = list(raw)
    higher[axis] = min(raw[axis] + step, HIGH)
    cal = ImuCal(*config)
    assert cal.apply(higher)[axis] >= cal.apply(raw)[axis]


@given(config=configs, raws=st.lists(vectors, max_size=20))
def test_imu_cal_block_is_the_same_as_steps(config, raws):
    cal, steps = ImuCal(*config), ImuCal(*config)
    given_ = np.array(raws, dtype=np.int16).reshape(-1, 3)
    block = cal.block(given_)
    assert given_.tolist() == [list(raw) for raw in raws]
    assert block.tolist() == [list(steps.apply(raw)) for raw in raws]
    assert cal.clipped == steps.clipped


@given(config=configs, before=vectors, after=vectors, slope=slopes, warmth=int16)
def test_imu_cal_saved_restored_or_copied_continues_identically(
    config, before, after, slope, warmth
):
    cal, restored = ImuCal(*config), ImuCal(*config)
    for each in (cal, restored):
        each.set_temperature(warmth, slope)
    cal.apply(before)
    copy = cal.copy()
    restored.restore(cal.save())
    expected = cal.apply(after)
    assert copy.apply(after) == restored.apply(after) == expected
    assert copy.clipped == restored.clipped == cal.clipped


@given(orientation=orientations, vector=vectors)
def test_imu_cal_turn_is_its_exact_twin_and_the_model(orientation, vector):
    turned = ImuTurn(orientation).apply(vector)
    assert turned == exact_imu.imu_cal_turn(orientation, vector)
    truth = model.orientation_matrix(orientation) @ vector
    assert np.array_equal(turned, np.minimum(truth, HIGH))


@given(orientation=orientations, raws=st.lists(vectors, max_size=20))
def test_imu_cal_turn_of_a_block_is_the_same_as_steps(orientation, raws):
    turn = ImuTurn(orientation)
    block = turn.block(np.array(raws, dtype=np.int16).reshape(-1, 3))
    assert block.tolist() == [list(turn.apply(raw)) for raw in raws]


def test_imu_cal_orientations_are_the_24_rotations_of_a_cube():
    rotations = [model.orientation_matrix(code) for code in model.ORIENTATIONS.values()]
    assert len({rotation.tobytes() for rotation in rotations}) == len(model.ORIENTATIONS) == 24
    for rotation in rotations:
        assert np.array_equal(rotation @ rotation.T, np.eye(3))
        assert np.linalg.det(rotation) == pytest.approx(1)
    assert model.ORIENTATIONS["px_py"] == ImuTurn().orientation
    assert np.array_equal(model.orientation_matrix(ImuTurn().orientation), np.eye(3))
    x, y, _ = model.orientation_matrix(model.ORIENTATIONS["nz_px"])
    assert (x.tolist(), y.tolist()) == ([0, 0, -1], [1, 0, 0])


def boards(seed):
    """Constants of a board as the MPU-6050's data sheet allows them, and raw values."""
    rng = np.random.default_rng(seed)
    matrix = np.eye(3) * rng.uniform(0.95, 1.05, 3) + rng.uniform(-0.02, 0.02, (3, 3))
    constants = {
        "matrix": matrix,
        "offset_counts": rng.uniform(-400, 400, 3),
        "slope_counts": rng.uniform(-0.06, 0.06, 3),
    }
    return constants, rng.integers(LOW, HIGH, (4000, 3), endpoint=True)


@pytest.mark.parametrize("warmth", [0, 11_900, -22_100])  # 35 degrees above, 65 below
@pytest.mark.parametrize("seed", range(4))
def test_imu_cal_stays_within_the_error_budget_of_the_model(seed, warmth):
    constants, raw = boards(seed)
    matrix, offset, slope = constants.values()
    cal = ImuCal(**model.config(matrix, offset))
    if warmth:
        cal.set_temperature(warmth, model.slope_q16(matrix, slope))
    error = cal.block(raw) - model.imu_cal(raw, **constants, above_reference=warmth)
    budget = model.error_budget_counts(raw, above_reference=warmth or None)
    assert np.all(np.abs(error).max(axis=1) <= budget)


def test_imu_cal_undoes_what_a_faulty_sensor_does():
    """Gravity in six positions through a faulty sensor comes out as gravity, within rounding."""
    constants, _ = boards(7)
    true = 2048 * np.vstack([np.eye(3), -np.eye(3)])
    measured = true @ np.linalg.inv(constants["matrix"]).T + constants["offset_counts"]
    cal = ImuCal(**model.config(constants["matrix"], constants["offset_counts"]))
    assert np.abs(cal.block(np.rint(measured).astype(int)) - true).max() <= 1.2
    assert cal.clipped == 0


def test_imu_cal_model_lets_no_number_stay_none():
    raw = np.array([[1.0, np.nan, 3.0], [4.0, 5.0, 6.0]])
    result = model.imu_cal(raw, matrix=np.eye(3), offset_counts=(0, 0, 0))
    assert np.isnan(result[0]).all()  # 0 * NaN: one bad axis spoils the vector
    assert result[1].tolist() == [4, 5, 6]


def test_imu_cal_refuses_what_breaks_the_contract():
    for matrix in ([[32767, 1, 0]] + [[0] * 3] * 2, [[0] * 3] * 2 + [[-10923] * 3]):
        with pytest.raises(ValueError, match="beyond imu_cal"):
            ImuCal(matrix)
    with pytest.raises(ValueError, match="beyond imu_cal"):
        ImuCal().set_temperature(0, (0, 0, -16385))
    with pytest.raises(ValueError, match="calibration"):
        ImuCal([[40_000, 0, 0]] + [[0] * 3] * 2)
    with pytest.raises(ValueError, match="calibration"):
        ImuCal(IDENTITY, (0, 32768, 0))
    with pytest.raises(ValueError, match="not the state"):
        ImuCal().restore(b"1")
    with pytest.raises(ValueError, match="row of M"):
        model.config(np.eye(3) * 1.6, (0, 0, 0))
    with pytest.raises(ValueError, match="4096"):
        model.config(np.eye(3), (0, 4096, 0))
    with pytest.raises(ValueError, match="slope"):
        model.slope_q16(np.eye(3), (0, 0, 0.3))
    for code in (9, 3, 64, -1):
        with pytest.raises(ValueError, match="no orientation"):
            model.orientation_matrix(code)
        with pytest.raises(ValueError, match="no orientation"):
            exact_imu.imu_cal_turn(code, (0, 0, 0))
