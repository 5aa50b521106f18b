# SPDX-License-Identifier: MIT
"""The golden vectors of zupt_gru hold inside the AVR binary, bit for bit."""

import random

import pytest

from target_vectors import avr_zupt_gru
from target_vectors.avr_core import AvrCore
from terazi.models import exact_zupt_gru
from terazi.models.vectors import golden
from tools.gen.zupt_gru_weights import weights

LYING = [(0, 0, 0, 0, 0, 2048)] * 200


@pytest.fixture(scope="module")
def avr(runner_zupt_gru_elf):
    return AvrCore(runner_zupt_gru_elf)


@pytest.mark.parametrize("vector", golden("zupt_gru_"), ids=str)
def test_zupt_gru_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    before = avr_zupt_gru.zupt_gru_rejected(avr)
    assert avr_zupt_gru.run(avr, vector) == avr_zupt_gru.answers_of(vector)
    assert avr_zupt_gru.zupt_gru_rejected(avr) - before == vector.parameter("rejected")


@pytest.mark.parametrize("sample_ms", [1, 2])
def test_zupt_gru_is_its_exact_twin_on_avr_on_noise_of_any_size(avr, sample_ms):
    rng = random.Random(sample_ms)
    samples = []
    for _ in range(500):
        sizes = [2 ** rng.uniform(0, 14) for _ in range(2)]
        samples.append(
            tuple(max(min(round(rng.gauss(0, sizes[n // 3])), 32767), -32768) for n in range(6))
        )
    twin, expected = exact_zupt_gru.ZuptGru(weights(), sample_ms), []
    for sample in samples:
        flag = twin.update(sample[:3], sample[3:])
        expected.append((flag, *twin.seen))
    avr_zupt_gru.zupt_gru_init(avr, sample_ms)
    assert avr_zupt_gru.zupt_gru(avr, samples) == expected


def test_zupt_gru_lies_still_on_avr_and_after_a_gap_begins_anew(avr):
    avr_zupt_gru.zupt_gru_init(avr, 1)
    assert avr_zupt_gru.zupt_gru(avr, LYING)[-1][0] == 1
    avr_zupt_gru.zupt_gru_interrupt(avr)
    first, *_ = avr_zupt_gru.zupt_gru(avr, LYING[:1])
    assert first == (0,) * 11
