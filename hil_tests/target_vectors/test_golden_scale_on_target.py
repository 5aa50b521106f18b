# SPDX-License-Identifier: MIT
"""The golden vectors of scale and checkweigher hold inside the AVR binary, bit for bit."""

import pytest

from target_vectors import avr_scale
from target_vectors.avr_core import AvrCore
from terazi.design import scale as design
from terazi.models.exact_scale import Status
from terazi.models.vectors import golden
from tools.measure.runner_scale import checkweigher_config_of, config_of

OUTCOME = ("steps", "step_us", "step_from_mg", "step_to_mg", "kept_mg")


@pytest.fixture(scope="module")
def avr(runner_scale_elf):
    return AvrCore(runner_scale_elf)


def rows(vector, *columns):
    return list(zip(*(vector[column] for column in columns), strict=True))


@pytest.mark.parametrize("vector", golden("scale_"), ids=str)
def test_scale_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    assert avr_scale.scale_init(avr, config_of(vector)) == Status.OK
    asked = rows(vector, "command", "argument", "raw", "counts", "device_us")
    assert avr_scale.scale(avr, asked) == rows(
        vector, "answer", "net_mg", "shown", "pieces", "mass_mg"
    )
    outcome = tuple(vector.parameter(f"final_{field}") for field in OUTCOME)
    assert avr_scale.scale_outcome(avr) == outcome


@pytest.mark.parametrize(
    ("changed", "status"),
    [
        ({"points": 1}, Status.BAD_COUNT),
        ({"point_counts_q7": [0, (1 << 30) + 1, *[0] * 6]}, Status.BAD_POINT),
        ({"point_mass_mg": [5, 5, *[0] * 6]}, Status.NOT_MONOTONE),
        ({"point_counts_q7": [0, 5_000_000, *[0] * 6]}, Status.TOO_STEEP),
        ({"interval_mg": 5_000_000 // 16 + 1}, Status.BAD_RANGE),
        ({"decimals": 4}, Status.BAD_DIVISION),
        ({"stable_us": 0}, Status.BAD_TIME),
    ],
)
def test_a_refused_configuration_changes_nothing_on_avr(avr, changed, status):
    usual = design.config()
    assert avr_scale.scale_init(avr, usual) == Status.OK
    before = avr_scale.scale(avr, [(0, 0, 55_000_000, 55_000_000, 12_500)])
    assert avr_scale.scale_init(avr, usual | changed) == status
    assert avr_scale.scale(avr, [(0, 0, 55_000_000, 55_000_000, 25_000)]) == before


@pytest.mark.parametrize("vector", golden("checkweigher_"), ids=str)
def test_checkweigher_reproduces_vector_bit_for_bit_on_avr(avr, vector):
    assert avr_scale.checkweigher_init(avr, checkweigher_config_of(vector))
    answers = avr_scale.checkweigher(avr, rows(vector, "mass_mg", "device_us"))
    assert answers == rows(vector, "event", "weighed_mg")
    last = ("weighed", "unweighed", "entered_us", "left_us", "per_minute_q8")
    wanted = tuple(vector.parameter(f"final_{field}") for field in last)
    assert avr_scale.checkweigher_outcome(avr) == wanted


def test_a_refused_checkweigher_changes_nothing_on_avr(avr):
    (vector,) = golden("checkweigher_belt")
    config = checkweigher_config_of(vector)
    assert avr_scale.checkweigher_init(avr, config)
    avr_scale.checkweigher(avr, rows(vector, "mass_mg", "device_us"))
    before = avr_scale.checkweigher_outcome(avr)
    assert not avr_scale.checkweigher_init(avr, config | {"leave_mg": config["enter_mg"]})
    assert avr_scale.checkweigher_outcome(avr) == before
