# SPDX-License-Identifier: MIT
"""imu_cal.c: golden vectors, laws for all inputs, and parity with the float64 model."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from terazi.cshared import ImuCal
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


offsets = st.integers(1 - model.OFFSET_LIMIT, model.OFFSET_LIMIT - 1)
slopes = st.integers(-model.SLOPE_MAX, model.SLOPE_MAX)
configs = st.tuples(
    st.tuples(lawful_rows(), lawful_rows(), lawful_rows()),
    st.tuples(offsets, offsets, offsets),
    st.tuples(slopes, slopes, slopes),
)


def words(vector, name):
    return [int(word) for word in vector.parameters[name].split()]


@pytest.mark.parametrize("vector", golden("imu_cal_"), ids=str)
def test_imu_cal_reproduces_vector_bit_for_bit(vector):
    matrix = np.reshape(words(vector, "matrix_q16"), (3, 3))
    cal = ImuCal(matrix, words(vector, "offset_q16"), words(vector, "slope_q16"))
    raws, wanted = (
        list(zip(*(vector[f"{kind}_{axis}_counts"] for axis in "xyz"), strict=True))
        for kind in ("raw", "true")
    )
    for raw, warmth, true in zip(raws, vector["above_reference_counts"], wanted, strict=True):
        cal.set_temperature(warmth)
        assert cal.apply(raw) == true
    assert cal.clipped == vector.parameter("clipped")


@given(config=configs, raws=st.lists(vectors, max_size=8), warmth=int16)
@example(
    config=([[32767, 0, 0]] * 3, [1 - (1 << 29)] * 3, [-16384] * 3), raws=[(HIGH,) * 3], warmth=HIGH
)
@example(
    config=([[32767, 0, 0]] * 3, [(1 << 29) - 1] * 3, [16384] * 3), raws=[(LOW,) * 3], warmth=HIGH
)
@example(
    config=([[-32767, 0, 0]] * 3, [1 - (1 << 29)] * 3, [16384] * 3), raws=[(LOW,) * 3], warmth=LOW
)
def test_imu_cal_is_its_exact_twin_for_any_lawful_constants(config, raws, warmth):
    cal = ImuCal(*config)
    cal.set_temperature(warmth)
    results, clipped = exact_imu.imu_cal(raws, *config, [warmth] * len(raws))
    assert [cal.apply(raw) for raw in raws] == results
    assert cal.clipped == clipped


@given(raw=vectors, warmth=int16)
def test_imu_cal_without_constants_passes_everything_on(raw, warmth):
    cal = ImuCal()
    cal.set_temperature(warmth)
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
    block = cal.block(np.array(raws, dtype=np.int16).reshape(-1, 3))
    assert block.tolist() == [list(steps.apply(raw)) for raw in raws]
    assert cal.clipped == steps.clipped


@given(config=configs, before=vectors, after=vectors, warmth=int16)
def test_imu_cal_saved_restored_or_copied_continues_identically(config, before, after, warmth):
    cal = ImuCal(*config)
    cal.set_temperature(warmth)
    cal.apply(before)
    copy, restored = cal.copy(), ImuCal(*config)
    restored.restore(cal.save())
    expected = cal.apply(after)
    assert copy.apply(after) == restored.apply(after) == expected
    assert copy.clipped == restored.clipped == cal.clipped


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
    cal = ImuCal(**model.config(*constants.values()))
    cal.set_temperature(warmth)
    error = cal.block(raw) - model.imu_cal(raw, **constants, above_reference=warmth)
    budget = model.error_budget_counts(raw, above_reference=warmth)
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
    for offset in (1 << 29, -(1 << 29)):
        with pytest.raises(ValueError, match="beyond imu_cal"):
            ImuCal(IDENTITY, (0, offset, 0))
    with pytest.raises(ValueError, match="beyond imu_cal"):
        ImuCal(IDENTITY, (0, 0, 0), (0, 0, -16385))
    with pytest.raises(ValueError, match="calibration"):
        ImuCal([[40_000, 0, 0]] + [[0] * 3] * 2)
    with pytest.raises(ValueError, match="not the state"):
        ImuCal().restore(b"1")
    with pytest.raises(ValueError, match="row of M"):
        model.config(np.eye(3) * 1.6, (0, 0, 0))
    with pytest.raises(ValueError, match="8192"):
        model.config(np.eye(3), (0, 9000, 0))
    with pytest.raises(ValueError, match="slope"):
        model.config(np.eye(3), (0, 0, 0), (0, 0, 0.3))
