# SPDX-License-Identifier: MIT
"""fir.c: golden vectors, laws for all inputs, and parity with the float64 model."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.cshared import FIR_DESIGNS, Fir, fir_block
from terazi.cshared._cshared import ffi, lib
from terazi.design import fir as design_fir
from terazi.design import specs
from terazi.models import exact
from terazi.models import fir as model
from terazi.models.vectors import golden

LOW, HIGH = exact.COUNTS_MIN, exact.COUNTS_MAX
counts = st.integers(LOW, HIGH)
any_int32 = st.integers(exact.INT32_MIN, exact.INT32_MAX)
designs = st.sampled_from(FIR_DESIGNS)


@st.composite
def lawful_taps(draw):
    """Symmetric coefficients as fir.h allows them: sum 32768, magnitudes below 65536."""
    pairs, alone = draw(st.integers(1, 32)), draw(st.booleans())
    alone = alone and pairs < 32
    bound = min(8000, 60000 // pairs)
    half = draw(st.lists(st.integers(-bound, bound), min_size=pairs, max_size=pairs))
    middle = [2 * draw(st.integers(-bound, bound))] * alone
    half[draw(st.integers(0, pairs - 1))] += 16384 - sum(half) - sum(middle) // 2
    taps = half + middle + half[::-1]
    if any(not -32768 <= tap <= 32767 for tap in taps) or sum(map(abs, taps)) >= 65536:
        half = [16384 // pairs] * pairs
        middle = [0] * alone
        half[-1] += 16384 - sum(half)
    return half + middle + half[::-1]


def fir_of(vector, **way):
    """The filter that a vector is about."""
    if "taps_q15" in vector.parameters:
        design = [int(tap) for tap in vector.parameters["taps_q15"].split()]
    else:
        design = vector.parameter("design")
    return Fir(design, vector.parameter("first_counts"), **way)


@pytest.mark.parametrize("by_heart", [False, True], ids=["generic", "by_heart"])
@pytest.mark.parametrize("vector", golden("fir_"), ids=str)
def test_fir_reproduces_vector_bit_for_bit(vector, by_heart):
    fir = fir_of(vector, by_heart=by_heart)
    assert [fir.update(x) for x in vector["sample_counts"]] == vector["result_counts"]
    assert fir.clipped == vector.parameter("clipped")


@given(taps=lawful_taps(), first=any_int32, samples=st.lists(any_int32, max_size=140))
def test_fir_is_its_exact_twin_for_any_lawful_coefficients(taps, first, samples):
    fir = Fir(taps, first)
    results, clipped = exact.fir(samples, taps, first)
    assert [fir.update(x) for x in samples] == results
    assert fir.clipped == clipped


@given(
    design=designs,
    first=any_int32,
    samples=st.lists(st.tuples(any_int32, st.booleans()), max_size=140),
)
def test_fir_answers_the_same_whichever_way_takes_which_sample(design, first, samples):
    mixed, generic = Fir(design, first), Fir(design, first)
    by_heart = mixed.copy(by_heart=True)
    for sample, hearty in samples:
        # One state, taken over from hand to hand.
        way = by_heart if hearty else mixed
        way.restore((mixed if hearty else by_heart).save())
        other = mixed if hearty else by_heart
        assert way.update(sample) == generic.update(sample)
        other.restore(way.save())
    assert mixed.clipped == by_heart.clipped == generic.clipped


@given(design=designs, data=st.data())
def test_fir_of_samples_backwards_is_the_result_backwards(design, data):
    """Symmetric coefficients cannot tell past from future: linear phase."""
    taps = Fir(design).taps
    samples = data.draw(st.lists(counts, min_size=taps, max_size=taps + 40))
    forwards = fir_block(samples, design)[taps - 1 :]
    backwards = fir_block(samples[::-1], design)[taps - 1 :]
    assert forwards.tolist() == backwards[::-1].tolist()


@given(taps=lawful_taps(), data=st.data())
def test_fir_never_leaves_the_bounds_that_its_coefficients_set(taps, data):
    samples = data.draw(st.lists(st.integers(-(2**21), 2**21), min_size=1, max_size=70))
    largest = max(map(abs, samples)) * sum(map(abs, taps))
    assert np.abs(fir_block(samples, taps)).max() <= (largest + (1 << 14)) >> 15


@pytest.mark.parametrize("design", FIR_DESIGNS)
def test_fir_is_late_by_half_its_length_less_one(design):
    fir = Fir(design, 0)
    assert fir.delay_samples == (fir.taps - 1) / 2 == design_fir.delay_samples(range(fir.taps))
    ramp = 64 * np.arange(4 * fir.taps)
    late = ramp - fir_block(ramp, design)
    assert np.all(late[fir.taps :] == 64 * fir.delay_samples)


def test_fir_with_most_gain_on_worst_samples_does_not_overflow():
    half = [-4095, -4096, 8191, 16384]
    taps = half + half[::-1]
    assert 65530 < sum(map(abs, taps)) < 65536
    worst = [HIGH if tap > 0 else LOW for tap in taps]
    for samples in (worst * 3, [LOW + HIGH - x for x in worst] * 3):
        results, clipped = exact.fir(samples, taps, 0)
        fir = Fir(taps, 0)
        assert fir.block(samples).tolist() == results
        assert fir.clipped == clipped > 0


@given(design=designs, level=counts, length=st.integers(1, 70))
def test_fir_primed_with_a_constant_answers_it_for_ever(design, level, length):
    assert fir_block([level] * length, design).tolist() == [level] * length


@given(first=counts, samples=st.lists(counts, min_size=1, max_size=70))
def test_fir_lowpass32_never_leaves_the_range_of_its_samples(first, samples):
    results = fir_block(samples, "lowpass32", first)
    seen = [first, *samples]
    assert min(seen) <= results.min()
    assert results.max() <= max(seen)


@given(design=designs, data=st.data(), length=st.integers(1, 70))
def test_fir_of_a_sum_is_the_sum_of_firs_but_for_rounding(design, data, length):
    series = st.lists(st.integers(LOW // 4, HIGH // 4), min_size=length, max_size=length)
    a, b = np.array(data.draw(series)), np.array(data.draw(series))
    difference = fir_block(a + b, design, 0) - fir_block(a, design, 0) - fir_block(b, design, 0)
    assert np.abs(difference).max() <= 1  # three roundings of at most half a count


@given(design=designs, shift=st.integers(-(2**20), 2**20), data=st.data())
def test_fir_follows_a_shift_of_all_samples_exactly(design, shift, data):
    samples = np.array(data.draw(st.lists(st.integers(-(2**22), 2**22), min_size=1, max_size=60)))
    shifted = fir_block(samples + shift, design)
    assert np.array_equal(shifted, fir_block(samples, design) + shift)


@given(
    design=designs,
    before=st.lists(any_int32, max_size=50),
    after=st.lists(any_int32, min_size=1, max_size=50),
)
def test_fir_saved_restored_or_copied_continues_identically(design, before, after):
    fir = Fir(design, 7)
    fir.block(before)
    copy, restored = fir.copy(), Fir(design, -1)
    restored.restore(fir.save())
    expected = fir.block(after).tolist()
    assert copy.block(after).tolist() == expected
    assert restored.block(after).tolist() == expected
    assert copy.clipped == restored.clipped == fir.clipped
    assert copy.save() == restored.save() == fir.save()


@given(
    design=st.one_of(designs, lawful_taps()),
    first=any_int32,
    blocks=st.lists(st.lists(any_int32, max_size=140), min_size=1, max_size=3),
)
def test_fir_block_is_the_same_as_steps_in_results_state_and_count(design, first, blocks):
    """The block goes another way, in float64; whatever was before or comes after, none can tell."""
    by_block, by_steps = Fir(design, first), Fir(design, first)
    for block in blocks:
        assert by_block.block(block).tolist() == [by_steps.update(x) for x in block]
        assert by_block.save() == by_steps.save()
        assert by_block.update(77) == by_steps.update(77)


@pytest.mark.parametrize("length", [511, 512, 513, 1024, 1500])
@pytest.mark.parametrize("design", FIR_DESIGNS)
def test_fir_block_longer_than_a_tile_is_the_same_as_steps(design, length):
    rng = np.random.default_rng(length)
    samples = rng.integers(LOW - 1000, HIGH + 1000, length)
    by_block, by_steps = Fir(design, 5), Fir(design, 5)
    assert by_block.block(samples).tolist() == [by_steps.update(int(x)) for x in samples]
    assert by_block.save() == by_steps.save()
    assert by_block.clipped == by_steps.clipped
    by_heart = by_block.copy(by_heart=True)
    assert [by_heart.update(x) for x in range(99)] == [by_steps.update(x) for x in range(99)]


def test_fir_counts_what_it_clips_and_the_counter_stops():
    fir = Fir("lowpass32", 0)
    fir.block([HIGH, LOW])
    assert fir.clipped == 0
    fir.block([HIGH + 1, LOW - 1])
    assert fir.clipped == 2
    fir.block(np.full(70_000, exact.INT32_MAX))
    assert fir.clipped == 65535


@pytest.mark.parametrize("design", FIR_DESIGNS)
@pytest.mark.parametrize("seed", range(4))
def test_fir_stays_within_the_error_budget_of_the_model(design, seed):
    rng = np.random.default_rng(seed)
    if seed == 0:
        samples = rng.integers(LOW, HIGH, 2000, endpoint=True)
    elif seed == 1:
        samples = np.repeat(rng.choice([LOW, HIGH], 60), 33)
    else:
        samples = np.rint(429_550 * seed + rng.normal(0, 38.7, 2000)).astype(int)
    budget = model.error_budget_counts(design, peak_to_peak_counts=np.ptp(samples))
    error = np.abs(fir_block(samples, design) - model.fir(samples, design=design))
    assert error.max() <= budget
    # The budget is a bound, not a licence: for a resting weight it is hardly more than rounding.
    if seed > 1:
        assert budget < 0.6


def test_fir_has_the_coefficients_of_the_specification():
    for design in FIR_DESIGNS:
        taps = specs.fir_taps_q15(design)
        impulse = fir_block([32768] + [0] * (len(taps) - 1), design, 0)
        assert impulse.tolist() == taps.tolist()


@pytest.mark.parametrize(
    "taps",
    [
        [16384, 1, 16384],
        [16384],
        [-16384, 32768, 32768, -16384],
        [16384, 40000, 16384],
        [512] * 65,
        [20000, 12768],
        [16384, 16385],
        [8192] * 2,
        [-8192, -8192, 32768, 32768, -8192, -8192],
        [32768 // 34] * 34,
    ],
)
def test_fir_refuses_coefficients_that_break_the_contract(taps):
    with pytest.raises(ValueError, match="taps must"):
        Fir(taps)


REFUSED_HALVES = {
    "no taps": (0, []),
    "one tap": (1, [32767]),
    "too many": (65, [992] * 33),
    "length that wraps": (255, [256] * 64),
    "sum too small": (4, [8192, 8191]),
    "sum too large": (3, [8192, 16385]),
    "too much gain": (6, [-8192, 8192, 16384]),
    "both extremes": (5, [-32768, 32767, 2]),
}


@pytest.mark.parametrize("reason", REFUSED_HALVES)
def test_fir_load_refuses_in_c_and_leaves_the_configuration(reason):
    taps, half = REFUSED_HALVES[reason]
    config = ffi.new("fir_config_t *", {"taps": 99})
    held = ffi.new("int16_t[]", half or [0])
    assert not lib.fir_load(config, held, taps)
    assert (config.taps, config.half_q15, config.loaded) == (99, ffi.NULL, False)


@given(taps=lawful_taps())
def test_fir_load_takes_whatever_is_lawful(taps):
    config = ffi.new("fir_config_t *")
    held = ffi.new("int16_t[]", taps[: (len(taps) + 1) // 2])
    assert lib.fir_load(config, held, len(taps))
    assert (config.taps, config.half_q15, config.loaded) == (len(taps), held, True)


def test_fir_refuses_what_is_not_samples():
    with pytest.raises(ValueError, match="no FIR design 'lowpass'"):
        Fir("lowpass")
    with pytest.raises(ValueError, match="no FIR design 9"):
        Fir(9)
    with pytest.raises(TypeError, match="integers"):
        fir_block([0.5])
    with pytest.raises(ValueError, match="32 bits"):
        fir_block([2**31])
    with pytest.raises(ValueError, match="one dimension"):
        fir_block([[1]])
    with pytest.raises(ValueError, match="not the state"):
        Fir().restore(b"short")
    assert fir_block([]).size == 0
