# SPDX-License-Identifier: MIT
"""The golden vectors of imu_cal and rest hold inside the AVR binary, bit for bit."""

import pytest

from target_vectors import avr_imu
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import golden


@pytest.fixture(scope="module")
def avr(runner_elf):
    return AvrCore(runner_elf)


def rows(vector, *columns):
    return list(zip(*(vector[column] for column in columns), strict=True))


@pytest.mark.parametrize("vector", golden("imu_cal_"), ids=str)
def test_imu_cal_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    constants = (
        [int(word) for word in vector.parameters[name].split()]
        for name in ("matrix_q16", "offset_q16", "slope_q16")
    )
    raws = rows(vector, "raw_x_counts", "raw_y_counts", "raw_z_counts")
    results, clipped = avr_imu.imu_cal(avr, *constants, raws, vector["above_reference_counts"])
    assert results == rows(vector, "true_x_counts", "true_y_counts", "true_z_counts")
    assert clipped == vector.parameter("clipped")


@pytest.mark.parametrize("vector", golden("rest_"), ids=str)
def test_rest_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    samples = rows(
        vector, *(f"{sensor}_{axis}_counts" for sensor in ("gyro", "acc") for axis in "xyz")
    )
    config = {field: vector.parameter(field) for field in avr_imu.REST_LAYOUT}
    results, rejected, implausible = avr_imu.rest(avr, config, samples)
    assert results == rows(vector, "flags", "bias_x_q16", "bias_y_q16", "bias_z_q16")
    assert rejected == vector.parameter("rejected")
    assert implausible == vector.parameter("implausible")
