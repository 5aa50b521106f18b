# SPDX-License-Identifier: MIT
"""weight_kf_adaptive.c: golden vectors, laws for all inputs, parity, and what it is there for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from terazi.cshared import (
    WEIGHT_KF_ADAPTIVE_VARIANTS,
    WeightKf,
    WeightKfAdaptive,
    WeightKfPair,
    fir_block,
    weight_kf_adaptive_block,
)
from terazi.models import exact
from terazi.models import weight_kf_adaptive as model
from terazi.models.exact_weight_kf_adaptive import Variant, adaptive
from terazi.models.vectors import golden

pytestmark = pytest.mark.no_cover  # millions of steps of models that other tests cover too

LOW, HIGH = exact.COUNTS_MIN, exact.COUNTS_MAX
SIGMA = 38.7  # HX711, 80 SPS
counts = st.integers(LOW, HIGH)
any_int32 = st.integers(exact.INT32_MIN, exact.INT32_MAX)
variants = st.sampled_from(WEIGHT_KF_ADAPTIVE_VARIANTS)
kinds = pytest.mark.parametrize("kind", [WeightKfAdaptive, WeightKfPair])


@st.composite
def configs(draw):
    """Any lawful configuration, as the C and the twin take it."""
    low, first, high = sorted(draw(st.integers(256, 32767)) for _ in range(3))
    return {
        "process_var_q16": draw(st.integers(0, 65535)),
        "noise_q8": first,
        "noise_min_q8": low,
        "noise_max_q8": high,
    }


@st.composite
def loads(draw):
    """Levels held for a while with noise on them, so that all branches are taken."""
    samples = []
    for _ in range(draw(st.integers(1, 6))):
        level, spread = draw(any_int32), draw(st.sampled_from([0, 1, 30, 3000, 1 << 22]))
        deviations = draw(st.lists(st.integers(-spread, spread), min_size=1, max_size=25))
        samples += [min(max(level + d, exact.INT32_MIN), exact.INT32_MAX) for d in deviations]
    return samples


@pytest.mark.parametrize("vector", golden("weight_kf_adaptive_"), ids=str)
def test_weight_kf_adaptive_reproduces_vector_bit_for_bit(vector):
    kind = WeightKfPair if vector.parameter("pair") else WeightKfAdaptive
    kf = kind(vector.parameter("variant"), vector.parameter("first_counts"))
    assert [kf.update(z) for z in vector["measured_counts"]] == vector["estimate_counts_q7"]
    assert kf.clipped == vector.parameter("clipped")


@kinds
@given(config=configs(), first=any_int32, measured=loads())
def test_weight_kf_adaptive_is_its_exact_twin_for_any_lawful_config(kind, config, first, measured):
    kf = kind(config, first)
    estimates, clipped = adaptive(measured, Variant(**config), first, pair=kind is WeightKfPair)
    assert [kf.update(z) for z in measured] == estimates
    assert kf.clipped == clipped


@kinds
@given(config=configs(), first=counts, measured=loads())
def test_weight_kf_adaptive_stays_within_what_it_has_seen(kind, config, first, measured):
    kf, low, high = kind(config, first), first, first
    for z in measured:
        low, high = min(low, max(z, LOW)), max(high, min(z, HIGH))
        assert low * 128 <= kf.update(z) <= high * 128
        assert config["noise_min_q8"] <= kf.noise_counts * 256 <= config["noise_max_q8"]


@kinds
@given(config=configs(), level=counts, length=st.integers(1, 60))
def test_weight_kf_adaptive_started_at_the_load_stays_there(kind, config, level, length):
    assert kind(config, level).block([level] * length).tolist() == [level * 128] * length


@kinds
@given(variant=variants, before=loads(), after=loads())
def test_weight_kf_adaptive_saved_restored_or_copied_continues_identically(
    kind, variant, before, after
):
    kf = kind(variant, 7)
    kf.block(before)
    copy, restored = kf.copy(), kind(variant, -1)
    restored.restore(kf.save())
    expected = kf.block(after).tolist()
    assert copy.block(after).tolist() == expected
    assert restored.block(after).tolist() == expected
    assert copy.save() == restored.save() == kf.save()


def long_run(count: int, *, spikes: bool, sigmas=(10.0, SIGMA, 100.0)) -> np.ndarray:
    """Steps of all sizes and both rails in noise that changes."""
    rng = np.random.default_rng(20)
    sizes = [0, 100, 300, 1000, 4000, 50_000, 429_550, LOW, HIGH, 12_345]
    level = np.repeat(rng.choice(sizes, count // 400), 400)
    sigma = np.repeat(rng.choice(sigmas, count // 5000), 5000)
    raw = np.clip(np.rint(level + sigma * rng.normal(0, 1, count)), LOW, HIGH).astype(int)
    if spikes:
        raw[rng.integers(0, count, count // 2000)] = HIGH
    return raw


@pytest.mark.parametrize("variant", WEIGHT_KF_ADAPTIVE_VARIANTS)
@pytest.mark.parametrize("behind_fir", [False, True], ids=["raw", "behind_fir"])
def test_weight_kf_adaptive_is_within_one_count_of_the_model(variant, behind_fir):
    """Over a million samples of what the device runs, a fifth of that of others; with steps and
    rails, alone with spikes and louder noise, too."""
    count = 1_000_000 if variant == "default" else 200_000
    measured = long_run(count, spikes=True)
    if behind_fir:
        measured = fir_block(long_run(count, spikes=False, sigmas=(10.0, SIGMA)))
    noise, learnt = np.empty(measured.size), np.empty(measured.size)
    kf = WeightKfAdaptive(variant, int(measured[0]))
    estimates = kf.block(measured, noise) / 128
    truth = model.weight_kf_adaptive(measured, variant=variant, learnt=learnt)
    assert np.abs(estimates - truth).max() < 1.0
    assert np.sqrt(np.mean((estimates - truth) ** 2)) < 0.1
    assert np.abs(noise / learnt - 1).max() < 0.03


def test_weight_kf_pair_differs_from_the_model_only_where_a_decision_was_on_the_brink():
    measured = long_run(200_000, spikes=True)
    for series in (measured, fir_block(measured)):
        truth = model.weight_kf_adaptive(series, pair=True)
        error = np.abs(weight_kf_adaptive_block(series, pair=True) / 128 - truth)
        assert np.median(error) < 0.05
        assert np.mean(error >= 1.0) < 1e-3


def test_weight_kf_adaptive_model_skips_what_is_not_a_number():
    measured = long_run(10_000, spikes=True).astype(float)
    holes = np.zeros(measured.size, bool)
    holes[[0, 1, 700, 701, 702, 4000]] = True  # at the start, in a row, alone
    whole = model.weight_kf_adaptive(measured[~holes])
    measured[holes] = np.nan
    estimates = model.weight_kf_adaptive(measured)
    assert np.array_equal(estimates[~holes], whole)
    assert estimates[701] == estimates[699]


def noise_at_rest(block, count=200_000) -> float:
    rng = np.random.default_rng(4)
    measured = np.rint(400_000 + rng.normal(0, SIGMA, count)).astype(int)
    return float((block(measured)[20_000:] / 128).std())


def constant_gain_of(noise_counts: float) -> list[int]:
    """A schedule 1, 1/2, ... that ends at the gain with this noise at rest: K / (2 - K) = ratio."""
    ratio = (noise_counts / SIGMA) ** 2
    steady = 2 * ratio / (1 + ratio)
    return [round(32768 * max(1 / n, steady)) for n in range(1, 256)]


def settled_after(estimates: np.ndarray, load: float, within: float) -> int:
    outside = np.flatnonzero(np.abs(estimates - load) > within)
    return int(outside[-1]) + 1 if outside.size else 0


@pytest.mark.parametrize("chain", ["alone", "behind_fir", "before_fir"])
@pytest.mark.parametrize("step_counts", [4000, 429_550])
def test_weight_kf_adaptive_settles_in_a_quarter_of_the_time_at_equal_noise(chain, step_counts):
    """To within 4 sigma of the noise at rest, the noise of both being the same."""

    def run(kf, measured):
        if chain == "behind_fir":
            return kf(fir_block(measured))
        return kf(measured) if chain == "alone" else fir_block((kf(measured) + 64) >> 7) * 128

    def adapts(measured):
        return run(weight_kf_adaptive_block, measured)

    at_rest = noise_at_rest(adapts)
    gains = constant_gain_of(at_rest)

    def is_constant(measured):
        return run(lambda z: WeightKf(gains, int(z[0])).block(z), measured)

    assert noise_at_rest(is_constant) == pytest.approx(at_rest, rel=0.1)
    times = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        measured = np.rint(rng.normal(0, SIGMA, 6000)).astype(int)
        measured[3000:] += step_counts
        quick, slow = adapts(measured)[3000:] / 128, is_constant(measured)[3000:] / 128
        times.append([settled_after(each, step_counts, 4 * at_rest) for each in (quick, slow)])
    quick, slow = np.median(times, axis=0)
    assert quick <= slow / 4


def test_weight_kf_adaptive_is_not_moved_by_one_spike():
    rng = np.random.default_rng(8)
    measured = np.rint(100_000 + rng.normal(0, SIGMA, 4000)).astype(int)
    calm = weight_kf_adaptive_block(measured)
    for spike in (LOW, HIGH, 110_000):
        measured[3000:3002] = [spike, measured[3001]]
        moved = weight_kf_adaptive_block(measured) - calm
        assert np.abs(moved).max() / 128 < 2.0  # K * 4 sigma
        assert np.abs(moved[3000]) > 0


@pytest.mark.parametrize("sigma", [2.0, 20.0, SIGMA, 100.0])
def test_weight_kf_adaptive_learns_the_noise(sigma):
    rng = np.random.default_rng(6)
    kf = WeightKfAdaptive("default", 0)
    noise = np.empty(40_000)
    kf.block(np.rint(rng.normal(0, sigma, noise.size)).astype(int), noise)
    assert noise[10_000:].mean() == pytest.approx(sigma, rel=0.1 if sigma < 5 else 0.03)
    assert kf.var_counts2 < kf.noise_counts**2


def test_weight_kf_pair_goes_on_as_if_nothing_had_been_when_the_load_comes_back():
    rng = np.random.default_rng(12)
    measured = np.rint(50_000 + rng.normal(0, SIGMA, 3000)).astype(int)
    measured[2000:2040] += 20_000
    pair = WeightKfPair("default", int(measured[0]))
    pair.block(measured[:2003])
    assert pair.is_moving
    rest_before = weight_kf_adaptive_block(measured[:2000])[-1]
    pair.block(measured[2003:2039])
    assert pair.is_moving or abs(pair.estimate_counts_q7 - 70_000 * 128) < 100 * 128
    after = pair.block(measured[2039:2060])
    assert not pair.is_moving
    # With a variance as small as before: a gain of half a percent, not one that starts anew.
    assert pair.var_counts2 < 0.02 * SIGMA**2 or abs(int(after[-1]) - int(rest_before)) < 40 * 128


def test_weight_kf_pair_rests_on_its_old_estimate_after_a_tap():
    rng = np.random.default_rng(13)
    measured = np.rint(50_000 + rng.normal(0, SIGMA, 3000)).astype(int)
    measured[2000:2005] += 20_000  # shorter than the moving model needs to call it rest
    pair = WeightKfPair("default", int(measured[0]))
    before = pair.block(measured[:2000])[-1]
    variance_before = pair.var_counts2
    pair.block(measured[2000:2040])
    assert not pair.is_moving
    assert pair.var_counts2 == pytest.approx(variance_before, rel=0.05)
    assert abs(pair.estimate_counts_q7 - int(before)) < 10 * 128


@kinds
def test_weight_kf_adaptive_refuses_what_breaks_the_contract(kind):
    with pytest.raises(ValueError, match="no adaptive variant 'quick'"):
        kind("quick")
    lawful = {"process_var_q16": 1, "noise_q8": 300, "noise_min_q8": 256, "noise_max_q8": 400}
    kind(lawful)
    for field, value in (("noise_min_q8", 255), ("noise_max_q8", 32768), ("noise_q8", 401)):
        with pytest.raises(ValueError, match="noise must lie within"):
            kind({**lawful, field: value})
    with pytest.raises(ValueError, match="not the state"):
        kind().restore(b"\0")
    assert weight_kf_adaptive_block([]).size == 0


@settings(max_examples=20)
@given(measured=loads())
def test_weight_kf_adaptive_block_is_the_same_as_steps(measured):
    kf = WeightKfAdaptive("default", measured[0])
    pair = WeightKfPair("default", measured[0])
    assert weight_kf_adaptive_block(measured).tolist() == [kf.update(z) for z in measured]
    assert weight_kf_adaptive_block(measured, pair=True).tolist() == [
        pair.update(z) for z in measured
    ]
