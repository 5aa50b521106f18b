# SPDX-License-Identifier: MIT
"""What a FIR costs on the chip hardly depends on the data: no sample can make a loop late."""

import pytest

from target_vectors.avr_core import AvrCore
from tools.measure.runner import CASES, fir_case

FIRS = {name: case for name, case in CASES.items() if name.startswith("fir")}
SPREAD_MAX = 0.1


@pytest.mark.parametrize("name", [*FIRS, "fir32_generic"])
def test_fir_takes_nearly_constant_time(runner_elf, name):
    case = FIRS.get(name) or fir_case(0)
    core = AvrCore(runner_elf)
    with core.profile([case.function]) as profile:
        case.drive(core)
    cost = profile.figures.functions[case.function]
    assert cost.calls > 500
    assert cost.max_cycles - cost.min_cycles <= SPREAD_MAX * cost.max_cycles


def test_straight_code_is_a_quarter_quicker_than_the_loop(runner_elf):
    core = AvrCore(runner_elf)
    most = []
    for case in (fir_case(0, by_heart=True), fir_case(0)):
        with core.profile([case.function]) as profile:
            case.drive(core)
        most.append(profile.figures.functions[case.function].max_cycles)
    assert most[0] < 0.77 * most[1]
