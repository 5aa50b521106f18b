# SPDX-License-Identifier: MIT
"""scale.h's configuration from physical quantities, which are in shared_c/spec/scale.toml."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from fractions import Fraction
from functools import cache

from terazi.design.specs import CHECKOUT, INSTALLED

POINTS_MAX = 8
DIGITS = (1, 2, 5)
TEN = 10
OPTIONS = {"initial_zero": 1, "track_zero": 2}
ONE_COUNT_Q7 = 128
MG_PER_G, UG_PER_MG, US_PER_S = 1000, 1000, 1_000_000
MANTISSA_BITS = 32


@cache
def spec() -> dict:
    """scale.toml, whole."""
    folder = INSTALLED if INSTALLED.is_dir() else CHECKOUT
    return tomllib.loads((folder / "scale.toml").read_text(encoding="utf-8"))


def unit_mg(unit: dict) -> Fraction:
    """A [[unit]]'s mass, exactly."""
    above, _, below = unit["mg"].partition("/")
    return Fraction(above) / Fraction(below or 1)


def units() -> list[str]:
    """Names, by index."""
    return [unit["name"] for unit in spec()["unit"]]


def reciprocal(mg: Fraction) -> tuple[int, int]:
    """1/mg as (mantissa of 32 bits, rounded down; exponent): mantissa * 2^-exponent."""
    exponent = MANTISSA_BITS - 1
    while (1 << exponent) / mg < 1 << MANTISSA_BITS - 1:
        exponent += 1
    return int((1 << exponent) / mg), exponent


def reciprocals(content: dict) -> list[tuple[int, int]]:
    """The table of scale_units.c: of ten of each unit, so that all digits go into it."""
    return [reciprocal(unit_mg(unit) * TEN) for unit in content["unit"]]


def default_points(content: dict | None = None) -> list[tuple[float, float]]:
    """(counts, gram) of a board that was never calibrated: at zero and at Max."""
    default = (content or spec())["default"]
    max_g = default["max_g"]
    return [(0.0, 0.0), (max_g * MG_PER_G * UG_PER_MG / default["span_ug_per_count"], max_g)]


def config(
    points: Sequence[tuple[float, float]] | None = None,
    content: dict | None = None,
    **changed,
) -> dict:
    """Fields of scale_config_t.

    points : (counts, gram), as a calibration finds them; None: those of the nominal cell.
    changed : keys of scale.toml's tables with another value; options as a list of names.
    """
    content = content or spec()
    tables: dict = {}
    for name in ("default", "stability", "display"):
        tables |= content[name]
    unknown = changed.keys() - tables.keys()
    if unknown:
        raise ValueError(f"scale.toml has no {', '.join(sorted(unknown))}")
    tables |= changed
    points = default_points(content) if points is None else list(points)
    spare = [0] * (POINTS_MAX - len(points))
    e_mg = round(tables["interval_g"] * MG_PER_G)
    names = [unit["name"] for unit in content["unit"]]
    if tables["unit"] not in names:
        raise ValueError(f"no unit {tables['unit']!r}; there are {', '.join(names)}")
    return {
        "max_mg": round(tables["max_g"] * MG_PER_G),
        "interval_mg": e_mg,
        "under_mg": round(tables["under_e"] * e_mg),
        "step_mg": round(tables["step_e"] * e_mg),
        "stable_band_mg": round(tables["band_e"] * e_mg),
        "stable_us": round(tables["time_s"] * US_PER_S),
        "gap_us": round(tables["gap_s"] * US_PER_S),
        "points": len(points),
        "unit": names.index(tables["unit"]),
        "decimals": tables["decimals"],
        "digit": tables["digit"],
        "hysteresis_q8": round(tables["hysteresis_d"] * 256),
        "options": sum(OPTIONS[name] for name in tables["options"]),
        "point_counts_q7": [round(counts * ONE_COUNT_Q7) for counts, _ in points] + spare,
        "point_mass_mg": [round(mass_g * MG_PER_G) for _, mass_g in points] + spare,
    }
