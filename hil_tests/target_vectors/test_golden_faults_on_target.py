# SPDX-License-Identifier: MIT
"""The golden vectors of faults hold inside the AVR binary, bit for bit."""

import pytest

from target_vectors import avr_faults
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import golden


@pytest.fixture(scope="module")
def avr(runner_faults_elf):
    return AvrCore(runner_faults_elf)


@pytest.mark.parametrize("vector", golden("faults_"), ids=str)
def test_faults_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    rows = zip(vector["event"], vector["counts"], strict=True)
    told, seen = avr_faults.faults(avr, vector.parameter("noise_counts"), rows)
    assert told == list(zip(vector["answer"], vector["held"], strict=True))
    assert seen == vector.parameter("final_seen")
