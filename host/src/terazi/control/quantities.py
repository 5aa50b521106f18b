# SPDX-License-Identifier: MIT
"""Quantities as people write them: 500, 500g, 0.5 kg, 300ms; and back."""

import re
from fractions import Fraction

from terazi.design import scale
from terazi.errors import UsageError

# What one of each unit is in the dimension's first unit.
DIMENSIONS = {
    "mass": {"ug": Fraction(1, 1000), "mg": Fraction(1)}
    | {
        name: scale.unit_mg(unit)
        for name, unit in zip(scale.units(), scale.spec()["unit"], strict=True)
    }
    | {"t": Fraction(10**9)},
    "time": {
        "us": Fraction(1),
        "ms": Fraction(1000),
        "s": Fraction(1_000_000),
        "min": Fraction(60_000_000),
        "h": Fraction(3_600_000_000),
    },
}

WRITTEN = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-zµ]*)\s*")


def parse(text: str, unit: str) -> Fraction:
    """The quantity in `unit`, exactly; what bears no unit is in it. Raises UsageError."""
    if "," in text:
        raise UsageError(f"{text!r}: write a point, as in 0.5, and nothing between thousands")
    found = WRITTEN.fullmatch(text)
    if found is None:
        raise UsageError(f"{text!r} is no number", remedy=f"Write it as 500 or 500{unit}.")
    number, written = Fraction(found[1]), found[2].replace("µ", "u")
    if not written or written == unit:
        return number
    units = next((units for units in DIMENSIONS.values() if unit in units), None)
    if units is None:
        raise UsageError(f"{text!r}: this is a number in {unit or 'no unit'}, no other is known")
    factor = units.get(written) or units.get(written.lower())
    if factor is None:
        raise UsageError(f"{text!r}: no unit {written}; there are {', '.join(units)}")
    return number * factor / units[unit]


def parse_mass_mg(text: str, unit: str = "g") -> int:
    """A mass in mg, in gram where it bears no unit. Raises UsageError."""
    return round(parse(text, unit) * DIMENSIONS["mass"][unit])


def show_mass(mass_mg: float, interval_mg: float = 100.0) -> str:
    """A mass for people, as finely as a tenth of e: 1 250.5 g, 2.5 kg stays 2500.0 g."""
    decimals = 0
    while decimals < 3 and interval_mg / 10 < 1000 / 10**decimals * 0.999:
        decimals += 1
    value = round(mass_mg / 1000, decimals) + 0.0
    return f"{value:,.{decimals}f} g".replace(",", " ")
