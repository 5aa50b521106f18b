# SPDX-License-Identifier: MIT
"""Max and e, and what goes with them: the display's division and the limits that are told in e."""

from fractions import Fraction

from terazi.control.quantities import show_mass
from terazi.cshared import Scale, ScaleRefusedError
from terazi.design import scale

DIVISIONS_LEAST = 16  # of Max in e: scale.h
DIVISIONS_CLASS_III = 10_000  # R76; more is no error, but no scale of class III
DECIMALS_MAX = 6
# Settings that follow e: name, so many e in scale.toml.
IN_E = {
    "scale.under_mg": "under_e",
    "scale.step_mg": "step_e",
    "scale.stable_band_mg": "band_e",
}
# What `changes` looks at.
RANGE_SETTINGS = (
    "scale.max_mg",
    "scale.interval_mg",
    "scale.unit",
    "scale.decimals",
    "scale.digit",
    *IN_E,
)


def why_not(max_mg: int, interval_mg: int) -> str:
    """What speaks against a pair of Max and e; "" if nothing does."""
    if not 0 < max_mg <= 500_000_000:
        return "Max lies between 1 mg and 500 kg"
    if interval_mg < 1:
        return "e is 1 mg at least"
    if interval_mg * DIVISIONS_LEAST > max_mg:
        return f"e is too coarse: at most Max / {DIVISIONS_LEAST}, {show_mass(max_mg / 16)}"
    if division_of(interval_mg, "g") is None:
        lower, upper = _round_ones(interval_mg)
        return f"e is 1, 2 or 5 times a power of ten: {show_mass(lower)} or {show_mass(upper)}"
    return "" if _makes_a_scale(max_mg, interval_mg) else "e is too fine for this Max, or at all"


def _makes_a_scale(max_mg: int, interval_mg: int) -> bool:
    """Whether the device's own C takes the pair, from the factory's settings on."""
    config = scale.config()
    now = {f"scale.{name}": value for name, value in config.items() if isinstance(value, int)}
    for name, value in changes(max_mg, interval_mg, now).items():
        config[name.removeprefix("scale.")] = value
    try:
        Scale(config)
    except ScaleRefusedError:
        return False
    return True


def division_of(interval_mg: int, unit: str) -> tuple[str, int, int] | None:
    """(unit, decimals, digit) of a display whose d is e; in kg where the unit has no such d."""
    for name in (unit, "kg"):
        unit_mg = scale.unit_mg(scale.spec()["unit"][scale.units().index(name)])
        for decimals in range(DECIMALS_MAX + 1):
            digit = Fraction(interval_mg) / unit_mg * 10**decimals
            if digit in scale.DIGITS:
                return name, decimals, int(digit)
    return None


def changes(max_mg: int, interval_mg: int, now: dict[str, int]) -> dict[str, int]:
    """Settings to be written for a new Max and e, by name; {} if nothing changes.

    Limits that were so many e stay so many e. The display's division becomes e, in its present
    unit if that can show it.
    """
    wanted = {"scale.max_mg": max_mg, "scale.interval_mg": interval_mg}
    before_mg = now["scale.interval_mg"]
    if interval_mg != before_mg:
        for name in IN_E:
            wanted[name] = round(Fraction(now[name] * interval_mg, before_mg))
        found = division_of(interval_mg, scale.units()[now["scale.unit"]])
        if found is not None:
            unit, decimals, digit = found
            wanted |= {
                "scale.unit": scale.units().index(unit),
                "scale.decimals": decimals,
                "scale.digit": digit,
            }
    return {name: value for name, value in wanted.items() if now[name] != value}


def usual_interval_mg(max_mg: int) -> int:
    """About a five-thousandth of Max, as 1, 2 or 5 times a power of ten."""
    ones = [digit * 10**power for power in range(8) for digit in scale.DIGITS]
    return min(ones, key=lambda one: abs(one * 5000 - max_mg))


def _round_ones(interval_mg: int) -> tuple[int, int]:
    """The nearest of 1, 2, 5 times a power of ten, below and above."""
    ones = [digit * 10**power for power in range(9) for digit in scale.DIGITS]
    return max(one for one in ones if one < interval_mg), min(
        one for one in ones if one > interval_mg
    )
