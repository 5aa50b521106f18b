# SPDX-License-Identifier: MIT
"""All figures of the budget in one dictionary: the public form of ``./dev budget --json``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tools.measure.cycles import SCENARIOS, run_scenario
from tools.measure.runner import measure_runner
from tools.measure.sizes import measure_sizes
from tools.measure.stack import StackDepth, measure_stack


class StackUnderestimated(Exception):
    """The chip went deeper than the call graph allows: the graph is wrong."""


@dataclass(frozen=True)
class Budget:
    figures: dict
    stack: StackDepth
    irq_off_where: str


def measure(elf: Path) -> Budget:
    sizes = measure_sizes(elf)
    stack = measure_stack(elf)
    runs = {name: run_scenario(elf, scenario) for name, scenario in SCENARIOS.items()}

    painted_bytes = max(run.stack_painted_bytes for run in runs.values())
    if painted_bytes > stack.total_bytes:
        raise StackUnderestimated(
            f"{painted_bytes} bytes of stack were used, {stack.total_bytes} computed"
        )
    longest = max(runs.values(), key=lambda run: run.irq_off_cycles_max)
    figures = {
        "flash_bytes": sizes.flash_bytes,
        "ram_static_bytes": sizes.ram_static_bytes,
        "stack_worst_bytes": stack.total_bytes,
        "stack_painted_bytes": painted_bytes,
        "irq_off_cycles_max": longest.irq_off_cycles_max,
        "hx711_irq_off_cycles_max": max(run.hx711_irq_off_cycles_max for run in runs.values()),
        "isr_cycles_max": max(run.isr_cycles_max for run in runs.values()),
        "cpu_load": {name: round(run.cpu_load, 4) for name, run in runs.items()},
        "cycles": {
            **{
                key: max(run.cycles[key] for run in runs.values())
                for key in next(iter(runs.values())).cycles
            },
            **{key: cost.max_cycles for key, cost in measure_runner().items()},
        },
    }
    return Budget(figures, stack, longest.irq_off_where)
