# SPDX-License-Identifier: MIT
"""scale_resume: a scale goes on with the zero and the tare of before."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.tests.shared_c.scales import RECIPROCALS, int32, lawful_configs, lying, times_us, weigh
from terazi.cshared import Scale, ScaleFlag
from terazi.design import scale as design
from terazi.models import exact_scale

MAX_MG = design.config()["max_mg"]


@given(
    config=lawful_configs(),
    zero_mg=int32,
    tare_mg=int32,
    firm=st.booleans(),
    counts_q7=st.lists(st.integers(-(1 << 28), 1 << 28), max_size=20),
)
def test_scale_resume_is_its_exact_twin(config, zero_mg, tare_mg, firm, counts_q7):
    ours, twin = Scale(config), exact_scale.Scale(config, RECIPROCALS)
    ours.resume(zero_mg, tare_mg, firm)
    twin.resume(zero_mg, tare_mg, firm)
    for counts, us in zip(counts_q7, times_us(len(counts_q7)).tolist(), strict=True):
        assert ours.update(counts, us) == twin.update(counts, us)
        assert (ours.zero_mg, ours.tare_mg, ours.net_mg) == (
            twin.zero_mg,
            twin.tare_mg,
            twin.net_mg,
        )


def test_scale_resume_firm_sets_no_zero_under_a_load():
    scale = Scale()
    scale.resume(12_000, 100_000, True)
    weigh(scale, lying(312.0))
    assert ScaleFlag.STABLE in ScaleFlag(scale.flags)
    assert abs(scale.net_mg - 200_000) <= 1


def test_scale_resume_not_firm_sets_its_zero_at_the_first_stable_mass():
    scale = Scale()
    scale.resume(12_000, 0, False)
    weigh(scale, lying(20.0))
    assert abs(scale.zero_mg - 20_000) <= 1
    assert scale.net_mg == 0


def test_scale_resume_keeps_the_zero_where_the_first_stable_mass_is_a_load():
    scale = Scale()
    scale.resume(12_000, 0, False)
    weigh(scale, lying(2012.0))
    assert scale.zero_mg == 12_000
    assert abs(scale.net_mg - 2_000_000) <= 1


@pytest.mark.parametrize("zero_mg", [MAX_MG * 12 // 100 + 1, -MAX_MG, (1 << 31) - 1, -(1 << 31)])
def test_scale_resume_passes_over_a_zero_too_far_off(zero_mg):
    scale = Scale()
    scale.resume(zero_mg, 0, True)
    assert scale.zero_mg == 0


@pytest.mark.parametrize("tare_mg", [-1, MAX_MG + 1, (1 << 31) - 1, -(1 << 31)])
def test_scale_resume_passes_over_a_tare_that_no_command_would_take(tare_mg):
    scale = Scale()
    scale.resume(0, tare_mg, True)
    assert scale.tare_mg == 0
    assert ScaleFlag.TARED not in ScaleFlag(scale.flags)
