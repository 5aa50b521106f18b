# SPDX-License-Identifier: MIT
"""weight_kf.c: golden vectors, laws for all inputs, and parity with the float64 model."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.cshared import WEIGHT_KF_SCHEDULES, WeightKf, fir_block, weight_kf_block
from terazi.models import exact
from terazi.models import fir as fir_model
from terazi.models import weight_kf as model
from terazi.models.vectors import golden

LOW, HIGH = exact.COUNTS_MIN, exact.COUNTS_MAX
counts = st.integers(LOW, HIGH)
any_int32 = st.integers(exact.INT32_MIN, exact.INT32_MAX)
schedules = st.sampled_from(WEIGHT_KF_SCHEDULES)
gain_lists = st.lists(st.integers(1, 32768), min_size=1, max_size=255)


SCHEDULED = [vector for vector in golden("weight_kf_") if "schedule" in vector.parameters]


@pytest.mark.parametrize("vector", SCHEDULED, ids=str)
def test_weight_kf_reproduces_vector_bit_for_bit(vector):
    schedule = WEIGHT_KF_SCHEDULES[int(vector.parameters["schedule"])]
    kf = WeightKf(schedule, vector.parameter("first_counts"))
    assert [kf.update(z) for z in vector["measured_counts"]] == vector["estimate_counts_q7"]
    assert kf.clipped == vector.parameter("clipped")


@given(gains=gain_lists, first=any_int32, measured=st.lists(any_int32, max_size=300))
def test_weight_kf_is_its_exact_twin_for_any_lawful_gains(gains, first, measured):
    kf = WeightKf(gains, first)
    estimates, clipped = exact.weight_kf(measured, gains, first)
    assert [kf.update(z) for z in measured] == estimates
    assert kf.clipped == clipped


@given(gains=gain_lists, first=counts, measured=st.lists(counts, min_size=1, max_size=60))
def test_weight_kf_estimate_never_passes_the_measurement(gains, first, measured):
    kf = WeightKf(gains, first)
    for z in measured:
        before = kf.estimate_counts_q7
        after = kf.update(z)
        assert min(before, z * 128) <= after <= max(before, z * 128)


@given(schedule=schedules, level=counts, length=st.integers(1, 80))
def test_weight_kf_started_at_the_load_stays_there(schedule, level, length):
    assert weight_kf_block([level] * length, schedule).tolist() == [level * 128] * length


@given(first=counts, z=any_int32)
def test_weight_kf_believes_the_first_measurement_of_the_default_schedule(first, z):
    assert WeightKf("default", first).update(z) == min(max(z, LOW), HIGH) * 128


def test_weight_kf_comes_to_rest_within_what_rounding_holds_back():
    """Half up: from below the estimate arrives; from above it stops where K e rounds to zero."""
    kf = WeightKf("default", 0)
    for target in (1_000_000, -1_000_000, 5, 4):
        kf.block([target] * 600)
        left_q7 = kf.estimate_counts_q7 - target * 128
        assert abs(left_q7) <= 0.5 * 32768 / 2805 + 1, f"target {target}"


@given(
    schedule=schedules,
    before=st.lists(any_int32, max_size=60),
    after=st.lists(any_int32, min_size=1, max_size=60),
)
def test_weight_kf_saved_restored_or_copied_continues_identically(schedule, before, after):
    kf = WeightKf(schedule, 7)
    kf.block(before)
    copy, restored = kf.copy(), WeightKf(schedule, -1)
    restored.restore(kf.save())
    expected = kf.block(after).tolist()
    assert copy.block(after).tolist() == expected
    assert restored.block(after).tolist() == expected
    assert copy.save() == restored.save() == kf.save()


@given(measured=st.lists(any_int32, min_size=1, max_size=80))
def test_weight_kf_block_is_the_same_as_steps(measured):
    kf = WeightKf("default", 3)
    assert weight_kf_block(measured, "default", 3).tolist() == [kf.update(z) for z in measured]


def loads(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    if seed == 0:
        return rng.integers(LOW, HIGH, 3000, endpoint=True)
    if seed == 1:
        return np.repeat(rng.choice([LOW, HIGH], 20), 150)
    steps = np.repeat(rng.integers(-(10**6), 10**6, 6), 500)
    return np.rint(steps + rng.normal(0, 38.7, 3000)).astype(int)


@pytest.mark.parametrize("schedule", WEIGHT_KF_SCHEDULES)
@pytest.mark.parametrize("seed", range(4))
def test_weight_kf_stays_within_the_error_budget_of_the_model(schedule, seed):
    measured = loads(seed)
    budget = model.error_budget_counts(measured, schedule=schedule)
    error = weight_kf_block(measured, schedule) / 128 - model.weight_kf(measured, schedule=schedule)
    assert np.all(np.abs(error) <= budget)


@pytest.mark.parametrize("schedule", WEIGHT_KF_SCHEDULES)
def test_weight_kf_is_within_one_count_of_the_model_with_its_own_gains(schedule):
    """Over a million samples, with steps and rails: rounding alone, 2^-8 / K at most."""
    rng = np.random.default_rng(21)
    level = np.repeat(rng.choice([LOW, HIGH, 0, 429_550, -77], 2500), 400)
    measured = np.clip(np.rint(level + rng.normal(0, 38.7, level.size)), LOW, HIGH).astype(int)
    truth = model.weight_kf(measured, schedule=schedule, rounded_gain=True)
    assert np.abs(weight_kf_block(measured, schedule) / 128 - truth).max() < 0.05


def test_weight_kf_budget_of_a_resting_load_is_below_a_tenth_of_a_count():
    rng = np.random.default_rng(5)
    measured = np.rint(429_550 + rng.normal(0, 38.7, 4000)).astype(int)
    budget = model.error_budget_counts(measured)
    assert budget[-1] < 0.1
    error = weight_kf_block(measured) / 128 - model.weight_kf(measured)
    assert np.abs(error).max() < budget.max() < 0.5


@pytest.mark.parametrize("seed", range(4))
def test_fir_then_weight_kf_stays_within_the_budget_of_the_chain(seed):
    raw = loads(seed)
    c_fir = fir_block(raw)
    true_fir = fir_model.fir(raw)
    fir_budget = fir_model.error_budget_counts(peak_to_peak_counts=np.ptp(raw))
    budget = model.error_budget_counts(true_fir, input_error_counts=fir_budget)
    error = weight_kf_block(c_fir) / 128 - model.weight_kf(true_fir)
    assert np.all(np.abs(error) <= budget)


def test_weight_kf_steady_gain_gives_the_noise_that_the_filter_believes():
    """Its own variance, K R, holds on a load that does what the model says."""
    rng = np.random.default_rng(11)
    count = 60_000
    load = 400_000 + np.cumsum(rng.normal(0, np.sqrt(12.0), count))
    measured = np.rint(load + rng.normal(0, np.sqrt(1500.0), count)).astype(int)
    error = (weight_kf_block(measured) / 128 - load)[200:]
    assert error.var() == pytest.approx(model.steady_variance_counts2(), rel=0.05)
    assert abs(error.mean()) < 0.5


def test_weight_kf_refuses_what_breaks_the_contract():
    with pytest.raises(ValueError, match="no gain schedule 'fast'"):
        WeightKf("fast")
    for gains in ([], [0], [32769], [1] * 256):
        with pytest.raises(ValueError, match="1 to 255 gains"):
            WeightKf(gains)
    with pytest.raises(ValueError, match="not the state"):
        WeightKf("average").restore(b"\0\0\0\0\5\0\0")
    assert weight_kf_block([]).size == 0
