# SPDX-License-Identifier: MIT
"""Configurations of mahony, rest, temperature: each bound of a header holds, one beyond fails."""

import pytest

from terazi.cshared import Mahony, Rest, Temperature
from terazi.design import mahony as mahony_design
from terazi.design import rest as rest_design

MAHONY = mahony_design.config_at(500.0, "second_order")
REST = rest_design.config_at(500.0)
MODES = {name: number for number, name in enumerate(mahony_design.MODES)}

# of a field: what is lawful, and what is just beyond
MAHONY_BOUNDS = {
    "gyro_q33": ((1, 16128), (0, 16129)),
    "square": ((0, 993), (994,)),
    "cubic": ((0, 2700), (2701,)),
    "correct_q18": ((1, 4095), (0, 4096)),
    "lowpass_q16": ((1, 4095), (0, 4096)),  # 0: not of second order
    "start_shift": ((0, 30), (31,)),
    "ramp_mask": ((0, 1, 63), (2, 62, 64)),
    "mag_correct_q21": ((1, 14000), (0, 14001)),
    "mag_learn_q16": ((0, 32767), (32768,)),
    "acc_one_g": ((0, 32767), (32768,)),
    "moving_min": ((0, 32767), (32768,)),
    "steps": ((1, 255), (0,)),
    "integral": ((0, 32767), (32768,)),
    "mode": ((MODES["second_order"],), (MODES["linear"], MODES["classic"], 3)),
}
REST_BOUNDS = {
    "enter_acc_counts": ((0, REST["leave_acc_counts"]), (-1, REST["leave_acc_counts"] + 1)),
    "leave_acc_counts": ((REST["enter_acc_counts"], 16383), (REST["enter_acc_counts"] - 1, 16384)),
    "enter_gyro_counts": ((0, REST["leave_gyro_counts"]), (-1, REST["leave_gyro_counts"] + 1)),
    "leave_gyro_counts": (
        (REST["enter_gyro_counts"], 2046 - REST["bias_max_counts"]),
        (REST["enter_gyro_counts"] - 1, 2047 - REST["bias_max_counts"]),
    ),
    "bias_max_counts": (
        (0, 2046 - REST["leave_gyro_counts"]),
        (-1, 2047 - REST["leave_gyro_counts"]),
    ),
    "lowpass_q16": ((1, 32767), (0, -1)),
    "still_rounds": ((1,), (0,)),
    "gain_len": ((1, 255), (0,)),
}
TEMPERATURE_BOUNDS = {
    "origin_counts": ((-(1 << 23), (1 << 23) - 1), (-(1 << 23) - 1, 1 << 23)),
    "reference_centi": ((-8500, 8500), (-8501, 8501)),
    "zero_counts_per_k_q4": ((-32768, 32767), ()),  # all that its type holds
    "span_ppm_per_k_q4": ((-4000, 4000), (-4001, 4001)),
}


def cases(bounds, which):
    return [(field, value) for field, found in bounds.items() for value in found[which]]


def made(module, field, value):
    if module is Temperature:
        return Temperature(**{field: value})
    return module({**(MAHONY if module is Mahony else REST), field: value})


ALL = [(Mahony, MAHONY_BOUNDS), (Rest, REST_BOUNDS), (Temperature, TEMPERATURE_BOUNDS)]
LAWFUL, BEYOND = (
    [(module, *case) for module, bounds in ALL for case in cases(bounds, which)] for which in (0, 1)
)


@pytest.mark.parametrize(("module", "field", "value"), LAWFUL)
def test_a_configuration_at_a_bound_is_taken(module, field, value):
    made(module, field, value)


@pytest.mark.parametrize(("module", "field", "value"), BEYOND)
def test_a_configuration_beyond_a_bound_is_refused(module, field, value):
    with pytest.raises(ValueError, match=r"configuration|compensation"):
        made(module, field, value)
