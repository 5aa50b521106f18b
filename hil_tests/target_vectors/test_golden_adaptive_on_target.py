# SPDX-License-Identifier: MIT
"""The golden vectors of weight_kf_adaptive hold inside the AVR binary, bit for bit."""

import pytest

from target_vectors import avr_adaptive
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import golden


@pytest.fixture(scope="module")
def avr(runner_elf):
    return AvrCore(runner_elf)


@pytest.mark.parametrize("vector", golden("weight_kf_adaptive_"), ids=str)
def test_weight_kf_adaptive_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    estimates, clipped = avr_adaptive.adaptive(
        avr,
        vector.parameter("variant"),
        vector.parameter("first_counts"),
        vector["measured_counts"],
        pair=bool(vector.parameter("pair")),
    )
    assert estimates == vector["estimate_counts_q7"]
    assert clipped == vector.parameter("clipped")
