# SPDX-License-Identifier: MIT
"""``./dev budget [--json]``: the built firmware against firmware/budget.toml."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tools.measure.budget import Budget, StackUnderestimated, measure
from tools.measure.compiler import REFERENCE_COMPILER, compiler_version, is_reference
from tools.measure.limits import BUDGET, Line, compare, load_limits
from tools.measure.stack import UnboundedStack

ROOT = BUDGET.parents[1]
IMAGE = ROOT / ".build" / "firmware" / "terazi.elf"


def show(budget: Budget, lines: list[Line]) -> None:
    table = Table(title=f"{IMAGE.relative_to(ROOT)} against {BUDGET.relative_to(ROOT)}")
    table.add_column("figure")
    for heading in ("measured", "limit", "of limit"):
        table.add_column(heading, justify="right")
    for line in lines:
        table.add_row(
            line.name,
            f"{line.measured:g}",
            f"{line.limit:g}",
            f"{line.measured / line.limit:.0%}",
            style="bold red" if line.exceeded else None,
        )
    console = Console(highlight=False)
    console.print(table)
    stack = budget.stack
    console.print(
        f"deepest path: {' -> '.join(stack.main_path)} ({stack.main_bytes} B), "
        f"handler {' -> '.join(stack.interrupt_path)} ({stack.interrupt_bytes} B); "
        f"seen while weighing: {budget.figures['stack_painted_bytes']} B"
    )
    console.print(f"longest critical section: in {budget.irq_off_where}")
    unlimited = set(budget.figures["cycles"]) - set(load_limits()["cycles"])
    for key in sorted(unlimited):
        console.print(f"cycles.{key}: {budget.figures['cycles'][key]} (no limit)")


def main() -> int:
    parser = argparse.ArgumentParser(prog="./dev budget", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object, nothing else")
    parser.add_argument("--elf", type=Path, default=IMAGE, help="image to measure")
    options = parser.parse_args()
    limits = load_limits()
    try:
        budget = measure(options.elf)
    except (StackUnderestimated, UnboundedStack) as problem:
        print(f"budget: {problem}", file=sys.stderr)
        return 1
    lines = list(compare(budget.figures, limits))
    if options.json:
        print(json.dumps({**budget.figures, "limits": limits}, indent=2))
    else:
        show(budget, lines)
    exceeded = [line for line in lines if line.exceeded]
    for line in exceeded:
        print(f"budget: {line.name} is {line.measured:g}, limit {line.limit:g}", file=sys.stderr)
    compiler = compiler_version()
    if exceeded and not is_reference(compiler):
        print(
            f"budget: the limits are those of avr-gcc {REFERENCE_COMPILER}; this is {compiler}, "
            "so they are not held against it",
            file=sys.stderr,
        )
        return 0
    return 1 if exceeded else 0


if __name__ == "__main__":
    sys.exit(main())
