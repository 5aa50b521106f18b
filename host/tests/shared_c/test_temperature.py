# SPDX-License-Identifier: MIT
"""temperature.c: golden vectors, laws for all inputs, and parity with the float64 model."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from terazi.cshared import Temperature
from terazi.models import exact_temperature as exact
from terazi.models import temperature as model
from terazi.models.vectors import golden
from tools.gen import golden_temperature
from tools.gen.spec import load

LOW, HIGH = -(1 << 23), (1 << 23) - 1
FIELDS = golden_temperature.FIELDS
counts = st.integers(LOW, HIGH)
centis = st.integers(exact.LOWEST_CENTI, exact.HIGHEST_CENTI)
int16 = st.integers(-(1 << 15), (1 << 15) - 1)
configs = st.fixed_dictionaries(
    {
        "origin_counts": counts,
        "reference_centi": centis,
        "zero_counts_per_k_q4": int16,
        "span_ppm_per_k_q4": st.integers(-4000, 4000),
        "on": st.booleans(),
    }
)


def config_of(vector):
    return {field: vector.parameter(field) for field in FIELDS}


@pytest.mark.parametrize("vector", golden("temperature_"), ids=str)
def test_temperature_reproduces_vector_bit_for_bit(vector):
    temperature = Temperature(**config_of(vector))
    none = golden_temperature.NO_READING
    columns = ("measured_centi", "raw_counts", "smoothed_centi", "corrected_counts")
    rows = zip(*(vector[column] for column in columns), strict=True)
    for measured, raw, smoothed, corrected in rows:
        if measured != none:
            temperature.update(measured)
        assert temperature.centi == (None if smoothed == none else smoothed)
        assert temperature.correct(raw) == corrected
    assert temperature.refused == vector.parameter("refused")
    assert temperature.clipped == vector.parameter("clipped")


@given(config=configs, readings=st.lists(int16, max_size=30), raws=st.lists(counts, max_size=8))
@example(
    config=dict(zip(FIELDS, (LOW, -4000, 32767, 4000, 1), strict=True)),
    readings=[8500],
    raws=[LOW, HIGH],
)
@example(
    config=dict(zip(FIELDS, (LOW, 8500, -32768, 4000, 1), strict=True)),
    readings=[-4000],
    raws=[LOW, HIGH],
)
def test_temperature_is_its_exact_twin_for_any_lawful_configuration(config, readings, raws):
    temperature, twin = Temperature(**config), exact.Temperature(config)
    for reading in readings:
        temperature.update(reading)
        twin.update(reading)
        assert temperature.centi == twin.centi
    for raw in raws:
        assert temperature.correct(raw) == twin.correct(raw)
    assert (temperature.refused, temperature.clipped) == (twin.refused, twin.clipped)


@given(config=configs, raw=counts)
def test_temperature_passes_counts_on_before_the_first_reading_and_at_the_reference(config, raw):
    temperature = Temperature(**config)
    assert temperature.correct(raw) == raw
    temperature.update(config["reference_centi"])
    assert temperature.correct(raw) == raw


@given(config=configs, readings=st.lists(centis, min_size=1, max_size=5), raw=counts)
def test_temperature_switched_off_changes_nothing(config, readings, raw):
    temperature = Temperature(**{**config, "on": False})
    for reading in readings:
        temperature.update(reading)
    assert temperature.correct(raw) == raw


@given(before=centis, wrong=int16)
def test_temperature_moves_by_a_quarter_of_a_kelvin_at_most_for_one_wrong_reading(before, wrong):
    temperature = Temperature()
    temperature.update(before)
    temperature.update(wrong)
    assert abs(temperature.centi - before) <= 25


@given(config=configs, reading=centis, raw=st.integers(LOW, HIGH - 1), step=st.integers(1, 1 << 20))
def test_temperature_never_turns_more_load_into_less(config, reading, raw, step):
    """A share of the span is below 3.2 %: whatever is heavier stays at least as heavy."""
    temperature = Temperature(**config)
    temperature.update(reading)
    assert temperature.correct(min(raw + step, HIGH)) >= temperature.correct(raw)


@given(config=configs, readings=st.lists(centis, max_size=6), after=centis, raw=counts)
def test_temperature_saved_restored_or_copied_continues_identically(config, readings, after, raw):
    temperature, restored = Temperature(**config), Temperature(**config)
    for reading in readings:
        temperature.update(reading)
    copy = temperature.copy()
    restored.restore(temperature.save())
    for each in (temperature, copy, restored):
        each.update(after)
    assert copy.centi == restored.centi == temperature.centi
    assert copy.correct(raw) == restored.correct(raw) == temperature.correct(raw)


@given(config=configs, rows=st.lists(st.tuples(counts, st.none() | int16), max_size=20))
def test_temperature_block_is_the_same_as_steps(config, rows):
    block, steps = Temperature(**config), Temperature(**config)
    expected = []
    for raw, reading in rows:
        if reading is not None:
            steps.update(reading)
        expected.append(steps.correct(raw))
    raws = np.array([raw for raw, _ in rows], dtype=np.int64)
    readings = np.array([np.nan if each is None else each for _, each in rows], dtype=float)
    assert block.block(raws, readings).tolist() == expected
    assert block.refused == steps.refused


@pytest.mark.parametrize("above_k", [0.25, 30.0, -60.0])
@pytest.mark.parametrize("seed", range(4))
def test_temperature_stays_within_the_error_budget_of_the_model(seed, above_k):
    rng = np.random.default_rng(seed)
    zero_q4, span_q4 = int(rng.integers(-4000, 4000)), int(rng.integers(-2000, 2000))
    origin = int(rng.integers(-200_000, 200_000))
    temperature = Temperature(
        origin_counts=origin,
        reference_centi=2000,
        zero_counts_per_k_q4=zero_q4,
        span_ppm_per_k_q4=span_q4,
    )
    temperature.update(2000 + round(100 * above_k))
    raw = rng.integers(-4_000_000, 4_000_000, 3000)
    physical = {
        "zero_counts_per_k": zero_q4 / 16,
        "span_ppm_per_k": span_q4 / 16,
        "origin_counts": origin,
    }
    error = np.abs(temperature.block(raw) - model.correct(raw, above_k, **physical))
    assert np.all(error <= model.error_budget_counts(raw, above_k, **physical))


def test_temperature_smoothing_stays_within_its_budget_of_the_model():
    rng = np.random.default_rng(5)
    readings = 2500 + np.cumsum(rng.integers(-60, 61, 3000))
    readings = np.clip(readings, exact.LOWEST_CENTI, exact.HIGHEST_CENTI)
    temperature, smoothed = Temperature(), []
    for reading in readings:
        temperature.update(int(reading))
        smoothed.append(temperature.centi / 100)
    error = np.abs(np.array(smoothed) - model.smooth(readings / 100))
    assert error.max() <= model.SMOOTHED_BUDGET_K


def test_temperature_twin_and_specification_name_the_same_limits():
    content = load("temperature").content
    assert content["range"] == {
        "lowest_centi": exact.LOWEST_CENTI,
        "highest_centi": exact.HIGHEST_CENTI,
    }
    assert content["smoothing"] == {
        "shift": exact.SMOOTHING_SHIFT,
        "step_max_centi": exact.STEP_MAX_CENTI,
    }
    assert content["limits"]["span_max_ppm_per_k"] * 16 == exact.SPAN_MAX_PPM_PER_K_Q4


def test_temperature_refuses_what_breaks_the_contract():
    for field, value in {
        "origin_counts": HIGH + 1,
        "reference_centi": exact.HIGHEST_CENTI + 1,
        "span_ppm_per_k_q4": -4001,
    }.items():
        with pytest.raises(ValueError, match="beyond temperature"):
            Temperature(**{field: value})
    with pytest.raises(ValueError, match="compensation"):
        Temperature(zero_counts_per_k_q4=1 << 15)
    with pytest.raises(ValueError, match="24 bits"):
        Temperature().correct(HIGH + 1)
    with pytest.raises(ValueError, match="24 bits"):
        Temperature().block([LOW - 1])
    with pytest.raises(ValueError, match="readings"):
        Temperature().block([1, 2], [20.0])
    with pytest.raises(ValueError, match="not the state"):
        Temperature().restore(b"1")
