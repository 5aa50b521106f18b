# SPDX-License-Identifier: MIT
"""firmware/budget.toml against what was measured."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

BUDGET = Path(__file__).resolve().parents[2] / "firmware" / "budget.toml"


@dataclass(frozen=True)
class Line:
    """One line of the budget: a figure beside its limit."""

    name: str
    measured: float
    limit: float

    @property
    def exceeded(self) -> bool:
        return self.measured > self.limit


def load_limits(path: Path = BUDGET) -> dict:
    return tomllib.loads(path.read_text())


def compare(measured: dict, limits: dict, prefix: str = "") -> Iterator[Line]:
    """A line for every limit. A limit that nothing measures is an error: it would never fail."""
    for key, limit in limits.items():
        if key not in measured:
            raise KeyError(f"{BUDGET.name} limits {prefix}{key}, which nothing measures")
        if isinstance(limit, dict):
            yield from compare(measured[key], limit, f"{prefix}{key}.")
        else:
            yield Line(prefix + key, measured[key], limit)
