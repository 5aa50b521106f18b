# SPDX-License-Identifier: MIT
"""The golden vectors of temperature hold inside the AVR binary, bit for bit."""

import pytest

from target_vectors import avr_temperature
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import golden

NO_READING = -32768


@pytest.fixture(scope="module")
def avr(runner_temperature_elf):
    return AvrCore(runner_temperature_elf)


def none_where_none(values):
    return [None if value == NO_READING else value for value in values]


@pytest.mark.parametrize("vector", golden("temperature_"), ids=str)
def test_temperature_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    config = {field: vector.parameter(field) for field in avr_temperature.FIELDS}
    assert avr_temperature.temperature_init(avr, config)
    rows = zip(none_where_none(vector["measured_centi"]), vector["raw_counts"], strict=True)
    wanted = zip(none_where_none(vector["smoothed_centi"]), vector["corrected_counts"], strict=True)
    assert avr_temperature.temperature(avr, rows) == list(wanted)
    counts = (vector.parameter("refused"), vector.parameter("clipped"))
    assert avr_temperature.temperature_counts(avr) == counts


def test_temperature_beyond_its_bounds_is_refused_on_avr(avr):
    lawful = dict.fromkeys(avr_temperature.FIELDS, 0)
    assert not avr_temperature.temperature_init(avr, {**lawful, "span_ppm_per_k_q4": 4001})
    assert not avr_temperature.temperature_init(avr, {**lawful, "reference_centi": -8501})
    assert not avr_temperature.temperature_init(avr, {**lawful, "origin_counts": 1 << 23})
