# SPDX-License-Identifier: MIT
"""The golden vectors of mahony hold inside the AVR binary, bit for bit."""

import pytest

from target_vectors import avr_mahony
from target_vectors.avr_core import AvrCore
from terazi.models import exact_mahony
from terazi.models.vectors import golden

VECTORS = golden("mahony_")
INPUTS = (
    "gap_samples",
    *(f"{sensor}_{axis}_counts" for sensor in ("gyro", "acc", "mag") for axis in "xyz"),
    *(f"bias_{axis}_q16" for axis in "xyz"),
)
OUTPUTS = (*(f"quat_{part}_q30" for part in "wxyz"), "roll_q13", "pitch_q13", "yaw_q13")


@pytest.fixture(scope="module")
def avr(runner_elf):
    return AvrCore(runner_elf)


def rows(vector, columns):
    return list(zip(*(vector[column] for column in columns), strict=True))


def replayed(avr, vector):
    config = {field: vector.parameter(field) for field in avr_mahony.CONFIG_LAYOUT}
    return avr_mahony.mahony(avr, config, rows(vector, INPUTS), axes=vector.parameter("axes"))


@pytest.mark.parametrize("vector", [v for v in VECTORS if v.header["kind"] == "model"], ids=str)
def test_mahony_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    results, counts = replayed(avr, vector)
    assert results == rows(vector, OUTPUTS)
    assert counts == {name: vector.parameter(f"counted_{name}") for name in avr_mahony.COUNTS}


@pytest.mark.parametrize("vector", [v for v in VECTORS if v.header["kind"] == "published"], ids=str)
def test_mahony_keeps_to_the_closed_form_on_avr(avr, vector):
    results, _ = replayed(avr, vector)
    for result, truth in zip(results, rows(vector, OUTPUTS), strict=True):
        for got, wanted in zip(result[:4], truth[:4], strict=True):
            assert abs(got - wanted) <= vector.parameter("tolerance_q30")
        for got, wanted in zip(result[4:], truth[4:], strict=True):
            assert abs(got - wanted) <= vector.parameter("tolerance_q13")


def test_free_acceleration_is_that_of_the_twin_on_avr(avr):
    vector = next(v for v in VECTORS if v.name == "mahony_fast")
    replayed(avr, vector)
    twin = exact_mahony.Mahony({f: vector.parameter(f) for f in avr_mahony.CONFIG_LAYOUT})
    for _, *values in rows(vector, INPUTS):
        twin.update(values[0:3], values[3:6], values[9:12])
    for acc in ((0, 0, 2048), (-5000, 32767, 12), (-32768, -32768, -32768)):
        assert avr_mahony.free_acceleration(avr, acc) == tuple(twin.free_acceleration(acc))
