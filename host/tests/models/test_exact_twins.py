# SPDX-License-Identifier: MIT
"""The exact twins that make the vectors are themselves held to the float64 models."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.design import specs
from terazi.models import exact, fir, mass, weight_kf

COUNTS = st.lists(st.integers(exact.COUNTS_MIN, exact.COUNTS_MAX), min_size=1, max_size=100)


@given(samples=COUNTS, design=st.sampled_from([0, 1]))
def test_fir_twin_is_within_the_budget_of_the_model(samples, design):
    twin, _ = exact.fir(samples, specs.fir_taps_q15(design).tolist(), samples[0])
    truth = fir.fir(samples, design=design)
    budget = fir.error_budget_counts(design, peak_to_peak_counts=np.ptp(samples))
    assert np.abs(np.array(twin) - truth).max() <= budget


@given(measured=COUNTS, schedule=st.sampled_from([0, 1]))
def test_weight_kf_twin_is_within_the_budget_of_the_model(measured, schedule):
    twin, _ = exact.weight_kf(measured, specs.weight_kf_gains_q15(schedule), measured[0])
    truth = weight_kf.weight_kf(measured, schedule=schedule)
    budget = weight_kf.error_budget_counts(measured, schedule=schedule)
    assert np.all(np.abs(np.array(twin) / 128 - truth) <= budget)


@given(net=st.integers(-(2**40), 2**40), span=st.integers(0, 2**20))
def test_mass_twin_is_within_half_a_milligram_of_the_model(net, span):
    truth = float(mass.mass_mg(net / 128, span / 65536))
    if abs(truth) < 2**31 - 2:
        assert abs(exact.mass_mg(net, span) - truth) <= 0.5 + 1e-6


def test_weight_kf_model_is_the_published_step_table():
    """Weighing thesis, Table 3, to the printed digit."""
    estimates = weight_kf.weight_kf([157, 145, 154, 160, 156], schedule="average", first_counts=150)
    assert estimates.tolist() == pytest.approx([157, 151, 152, 154, 154.4])


def test_weight_kf_model_goes_on_where_the_table_of_the_c_ends():
    table = specs.weight_kf_gains("default")
    longer = weight_kf.gains("default", len(table) + 2000)
    assert longer[: len(table)].tolist() == table
    assert abs(longer[-1] - table[-1]) <= 1.01e-3 * longer[-1]
    assert np.all(np.diff(longer) <= 0)
    assert weight_kf.gains("average", 9)[5:].tolist() == [0.2] * 4


def test_fir_model_of_a_tone_has_the_gain_of_its_response():
    n = np.arange(4000)
    for name in ("lowpass32", "passband32"):
        tone = 100_000 * np.sin(2 * np.pi * 2.5 / 80 * n)
        settled = fir.fir(tone, design=name)[100:]
        phasor = 2 * np.mean(settled * np.exp(-2j * np.pi * 2.5 / 80 * n[100:]))
        taps = specs.fir_taps(name)
        expected = np.abs(np.exp(-2j * np.pi * 2.5 / 80 * np.arange(32)) @ taps)
        assert abs(phasor) / 100_000 == pytest.approx(expected, rel=2e-3)


def test_models_of_nothing_are_nothing():
    assert fir.fir([]).size == 0
    assert weight_kf.weight_kf([]).size == 0
    assert weight_kf.error_budget_counts([]).size == 0


@given(body=st.binary(max_size=600))
def test_cobs_twin_survives_the_round_trip_with_blocks_of_any_length(body):
    coded = exact.cobs_encode(body)
    assert 0 not in coded
    assert exact.cobs_decode(coded) == body
    assert len(coded) <= len(body) + 1 + len(body) // 254


def test_cobs_twin_knows_the_full_block():
    for length in (253, 254, 255, 508):
        body = b"x" * length
        assert exact.cobs_decode(exact.cobs_encode(body)) == body
    assert exact.cobs_encode(b"x" * 254) == b"\xff" + b"x" * 254
    assert exact.cobs_decode(b"\x05ab") is None
    assert exact.cobs_decode(b"\x00") is None
