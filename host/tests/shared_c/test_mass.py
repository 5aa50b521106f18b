# SPDX-License-Identifier: MIT
"""mass.c: golden vectors, exactness for all inputs, and parity with the float64 model."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from terazi.cshared import mass_mg_block
from terazi.cshared._cshared import lib
from terazi.models import exact
from terazi.models import mass as model
from terazi.models.vectors import golden

any_int32 = st.integers(exact.INT32_MIN, exact.INT32_MAX)
any_uint32 = st.integers(0, 2**32 - 1)
DEFAULT_SPAN_Q16 = lib.MASS_DEFAULT_SPAN_UG_PER_COUNT << 16


@pytest.mark.parametrize("vector", golden("mass_"), ids=str)
def test_mass_reproduces_vector_bit_for_bit(vector):
    pairs = zip(vector["net_counts_q7"], vector["span_ug_per_count_q16"], strict=True)
    assert [lib.mass_from_counts(net, span) for net, span in pairs] == vector["mass_mg"]


@given(net=any_int32, span=any_uint32)
@example(net=exact.INT32_MIN, span=2**32 - 1)
@example(net=exact.INT32_MAX, span=2**32 - 1)
def test_mass_is_exact_but_for_one_rounding(net, span):
    assert lib.mass_from_counts(net, span) == exact.mass_mg(net, span)


@given(quotient=st.integers(0, 2**31), sign=st.sampled_from((1, -1)), off=st.integers(-2, 2))
def test_mass_is_exact_beside_every_tie(quotient, sign, off):
    """net * span next to a half of a milligram: where a wrong rounding would show."""
    tie = (2 * quotient + 1) * (1 << 22) * 1000 + off
    for net_bits in (23, 27, 31):
        net = min(1 << net_bits, exact.INT32_MAX)
        span = min(tie // net, 2**32 - 1)
        assert lib.mass_from_counts(sign * net, span) == exact.mass_mg(sign * net, span)


def test_mass_divides_every_possible_digit_rightly():
    """Byte by byte division by 125 meets remainders 0..124 and bytes 0..255: all 32 000 of them."""
    # The quotient of n * 2^26 / (125 * 2^26): net 2^13 and span n * 2^13 make just that product.
    numbers = np.arange(1, 32_000)
    ours = [lib.mass_from_counts(1 << 13, int(n) << 13) for n in numbers]
    assert ours == [(2 * int(n) + 125) // 250 for n in numbers]


@given(a=any_int32, b=any_int32, span=any_uint32)
def test_mass_never_falls_when_counts_rise(a, b, span):
    assert lib.mass_from_counts(min(a, b), span) <= lib.mass_from_counts(max(a, b), span)


def test_mass_of_the_default_span_is_what_the_cell_says():
    """5 kg, 1 mV/V, gain 128: full scale of the cell is 1 mV/V * 128 / 0.5 of 2^23 counts."""
    full_scale_counts = 5_000_000 / (lib.MASS_DEFAULT_SPAN_UG_PER_COUNT / 1000)
    assert full_scale_counts == pytest.approx(2 * 128 * 1e-3 * 2**23, rel=2e-4)


@pytest.mark.parametrize("span_ug", [2328, 1, 64_000])
def test_mass_block_is_within_half_a_milligram_of_the_model(span_ug):
    rng = np.random.default_rng(3)
    kf_q7 = rng.integers(-(2**30), 2**30, 5000)
    tare_q7 = -12_345
    ours = mass_mg_block(kf_q7, tare_q7, span_ug << 16)
    truth = model.mass_mg((kf_q7 - tare_q7) / 128, span_ug)
    assert np.abs(ours - truth).max() <= 0.5 + 1e-6


def test_mass_block_refuses_what_does_not_fit():
    with pytest.raises(ValueError, match="2\\^30"):
        mass_mg_block([2**30 + 1], 0, DEFAULT_SPAN_Q16)
    with pytest.raises(ValueError, match="2\\^30"):
        mass_mg_block([0], -(2**30) - 1, DEFAULT_SPAN_Q16)
    with pytest.raises(OverflowError):
        mass_mg_block([0], 0, 2**32)
    assert mass_mg_block([], 0, DEFAULT_SPAN_Q16).size == 0
