# SPDX-License-Identifier: MIT
"""The golden vectors of zupt hold inside the AVR binary, bit for bit."""

import pytest

from target_vectors import avr_zupt
from target_vectors.avr_core import AvrCore
from terazi.design import zupt as design
from terazi.models.vectors import golden

LYING = [(0, 0, 0, 0, 0, 2048)] * 80


@pytest.fixture(scope="module")
def avr(runner_zupt_elf):
    return AvrCore(runner_zupt_elf)


@pytest.mark.parametrize("vector", golden("zupt_[!g]"), ids=str)
def test_zupt_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    assert avr_zupt.zupt_init(avr, avr_zupt.config_of(vector))
    assert avr_zupt.zupt(avr, avr_zupt.samples_of(vector)) == vector["still"]
    assert avr_zupt.zupt_rejected(avr) == vector.parameter("rejected")


@pytest.mark.parametrize("rate", design.spec()["rate"], ids=lambda rate: rate["name"])
@pytest.mark.parametrize("name", design.detectors())
def test_zupt_reads_the_spec_from_program_memory_on_avr(avr, name, rate):
    wanted = design.config(design.entry_of(name), design.spec()["sensor"], rate["stride"])
    assert avr_zupt.zupt_choose(avr, wanted["detector"], rate["stride"]) == wanted
    assert avr_zupt.zupt(avr, LYING)[-1] == 1
    avr_zupt.zupt_interrupt(avr)
    assert avr_zupt.zupt(avr, LYING[:1]) == [0]


def test_zupt_of_no_detector_is_never_still_on_avr(avr):
    for number in (0, 5, 255):
        avr_zupt.zupt_choose(avr, number, 1)
        assert not any(avr_zupt.zupt(avr, LYING))


def test_zupt_beyond_its_bounds_is_refused_on_avr(avr):
    lawful = design.config_at("shoe")
    assert not avr_zupt.zupt_init(avr, {**lawful, "gyro_weight": 7})
    assert not avr_zupt.zupt_init(avr, {**lawful, "begin_squares": [-2, -1]})
    assert not avr_zupt.zupt_init(avr, {**lawful, "detector": 4})
