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


def words(vector, name):
    return [int(word) for word in vector.parameters[name].split()]


@pytest.mark.parametrize("vector", golden("imu_cal_apply_"), ids=str)
def test_imu_cal_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    avr_imu.imu_cal_init(avr, words(vector, "matrix_q16"), words(vector, "offset_q3"))
    raws = rows(vector, "raw_x_counts", "raw_y_counts", "raw_z_counts")
    results, clipped = avr_imu.imu_cal_apply(avr, raws)
    assert results == rows(vector, "true_x_counts", "true_y_counts", "true_z_counts")
    assert clipped == vector.parameter("clipped")


@pytest.mark.parametrize("vector", golden("imu_cal_temperature"), ids=str)
def test_imu_cal_offsets_follow_the_temperature_bit_for_bit_on_avr(avr, vector):
    avr_imu.imu_cal_init(avr, [0] * 9, words(vector, "offset_q3"))
    slope = words(vector, "slope_q16")
    for warmth, *offset in rows(
        vector, "above_reference_counts", *(f"offset_{axis}_q3" for axis in "xyz")
    ):
        assert avr_imu.imu_cal_at_temperature(avr, slope, warmth) == tuple(offset)


@pytest.mark.parametrize("vector", golden("imu_cal_turn"), ids=str)
def test_imu_cal_turns_bit_for_bit_on_avr_and_only_as_a_part_can_stand(avr, vector):
    columns = (f"{side}_{axis}_counts" for side in ("part", "board") for axis in "xyz")
    for orientation, *counts in rows(vector, "orientation", *columns):
        assert avr_imu.imu_cal_turn(avr, orientation, counts[:3]) == tuple(counts[3:])
    for orientation in set(range(256)) - set(vector["orientation"]):
        assert avr_imu.imu_cal_turn(avr, orientation, (1, 2, 3)) is None


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
