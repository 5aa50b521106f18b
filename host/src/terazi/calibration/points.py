# SPDX-License-Identifier: MIT
"""What calibration points are worth: against a straight line, against one another, against sense.

The device judges once more, at CALIBRATE_END, by what its fixed point can hold (scale.h). Here is
what a person can get wrong: another mass than was said, a pan that touches, two masses too alike.

    residual    a point's mass less that of the least-squares line through all points
    span        from the least mass to the greatest
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from terazi.control.quantities import show_mass
from terazi.link.generated.messages import Point
from terazi.units import counts_from_q7

POINTS_MAX = 8
MASS_LARGEST_MG = 500_000_000  # SCALE_MAX_MG
STEEPEST_MG = 128  # a count: SCALE_TOO_STEEP

# A point may be e/4 wrong (R76's bound for zero and tare). Two points nearer than 10 e would give
# a line that is wrong by 5 %.
NEAR_E = 10
# A cheap cell bends by 0.1 % of its range; what lies ten times as far off the others' line is
# another mass, a touching pan, or a wrong word.
SUSPICIOUS_SHARE = 0.01
SUSPICIOUS_E = 5
# "You entered 500 g, the cell says about 50 g": so near to a power of ten, a digit slipped.
SLIP_SHARE = 0.05
# What lies above the greatest mass is extrapolated; an error there grows by the ratio.
REACH_SHARE = 0.5


@dataclass(frozen=True)
class Finding:
    """Something about a new point. A refusal cannot be overruled, a doubt can."""

    text: str
    is_refusal: bool
    remedy: str = ""


@dataclass(frozen=True)
class Residual:
    """One point beside the straight line."""

    point: Point
    line_mg: float  # what the line says of its counts
    off_mg: float  # mass less that

    def share(self, span_mg: float) -> float:
        """Of the span: the cell's non-linearity there."""
        return self.off_mg / span_mg if span_mg else 0.0


def line_through(points: Sequence[Point]) -> tuple[float, float]:
    """(mg a count, mg at zero counts) by least squares; two different counts at least."""
    counts = np.array([counts_from_q7(point.counts_q7) for point in points])
    mass_mg = np.array([point.mass_mg for point in points], np.float64)
    away = counts - counts.mean()
    slope = float(away @ mass_mg / (away @ away))
    return slope, float(mass_mg.mean() - slope * counts.mean())


def residuals(points: Sequence[Point]) -> list[Residual]:
    """Every point beside the line through all."""
    slope, origin_mg = line_through(points)
    found = []
    for point in points:
        line_mg = origin_mg + slope * counts_from_q7(point.counts_q7)
        found.append(Residual(point, line_mg, point.mass_mg - line_mg))
    return found


def span_mg(points: Sequence[Point]) -> int:
    """From the least mass to the greatest."""
    masses = [point.mass_mg for point in points]
    return max(masses) - min(masses)


def refuse_mass(points: Sequence[Point], mass_mg: int, interval_mg: int) -> Finding | None:
    """What speaks against a mass before it is put on; one that is there already is repeated."""
    if abs(mass_mg) > MASS_LARGEST_MG:
        return Finding("a mass may be 500 kg at most", True)
    others = [point.mass_mg for point in points if point.mass_mg != mass_mg]
    if len(others) >= POINTS_MAX:
        return Finding(f"a calibration holds {POINTS_MAX} points at most", True)
    near = min(others, key=lambda other: abs(other - mass_mg), default=None)
    if near is not None and abs(near - mass_mg) < NEAR_E * interval_mg:
        return Finding(
            f"{show_mass(mass_mg, interval_mg)} is too near to {show_mass(near, interval_mg)}: "
            f"points want {NEAR_E} e between them",
            True,
            f"Take a mass at least {show_mass(NEAR_E * interval_mg, interval_mg)} away.",
        )
    return None


def examine(
    points: Sequence[Point],
    new: Point,
    *,
    interval_mg: int,
    before_mg: float | None = None,
) -> Finding | None:
    """What speaks against a point that was taken; None if nothing does.

    points : those taken before, without one of the same mass.
    before_mg : what the calibration that held until now says of the new point's load, None where
        that one was the factory's.
    """
    together = sorted([*points, new], key=lambda point: point.mass_mg)
    return (
        _contradiction(together, new, interval_mg)
        or _against_others(points, new, interval_mg)
        or _slipped(points, new, interval_mg, before_mg)
    )


def _contradiction(together: list[Point], new: Point, interval_mg: int) -> Finding | None:
    """What the device would refuse, and which two points it is about."""
    # Against the other neighbour first: it is what the new one is measured by.
    pairs = sorted(pairwise(together), key=lambda pair: new not in pair)
    for low, high in pairs:
        counts = abs(high.counts_q7 - low.counts_q7) / 128
        if (high.mass_mg - low.mass_mg) >= STEEPEST_MG * counts:
            return Finding(
                f"{show_mass(low.mass_mg, interval_mg)} and {show_mass(high.mass_mg, interval_mg)} "
                f"differ by {counts:.0f} counts only: the cell hardly noticed",
                True,
                "Was the mass on the scale, and is the load cell's wiring whole?",
            )
    rising = [high.counts_q7 > low.counts_q7 for low, high in pairwise(together)]
    if all(rising) or not any(rising):
        return None
    usual = rising.count(True) * 2 > len(rising)
    wrong = [pair for pair, up in zip(pairwise(together), rising, strict=True) if up != usual]
    low, high = next((pair for pair in wrong if new in pair), wrong[0])
    return Finding(
        f"{show_mass(high.mass_mg, interval_mg)} moves the cell the other way than the other "
        f"points do, compared with {show_mass(low.mass_mg, interval_mg)}",
        True,
        "One of the two is not what was said, or the pan touches something.",
    )


def _against_others(points: Sequence[Point], new: Point, interval_mg: int) -> Finding | None:
    """How far the new point lies off the line of those before it."""
    if len(points) < 2:
        return None
    slope, origin_mg = line_through(points)
    says_mg = origin_mg + slope * counts_from_q7(new.counts_q7)
    reach_mg = max(span_mg(points), abs(new.mass_mg - points[0].mass_mg))
    bound_mg = max(SUSPICIOUS_SHARE * reach_mg, SUSPICIOUS_E * interval_mg)
    if abs(new.mass_mg - says_mg) <= bound_mg:
        return None
    return _doubt(new, says_mg, interval_mg, "by the points so far the cell says")


def _slipped(
    points: Sequence[Point], new: Point, interval_mg: int, before_mg: float | None
) -> Finding | None:
    """With nothing but the old calibration to compare with, only a slipped digit is sure."""
    if len(points) >= 2 or before_mg is None or new.mass_mg == 0 or before_mg == 0:
        return None
    ratio = new.mass_mg / before_mg
    if ratio <= 0:
        return None
    decades = round(math.log10(ratio))
    if decades == 0 or abs(ratio / 10.0**decades - 1) > SLIP_SHARE:
        return None
    return _doubt(new, before_mg, interval_mg, "by its calibration until now the cell says")


def _doubt(new: Point, says_mg: float, interval_mg: int, who: str) -> Finding:
    said = show_mass(new.mass_mg, interval_mg)
    return Finding(
        f"you entered {said}, {who} about {show_mass(says_mg, interval_mg)}",
        False,
        "Is it the mass that you meant, and does nothing else touch the pan?",
    )


def reach_warning(points: Sequence[Point], max_mg: int, interval_mg: int) -> str:
    """A word on points that leave most of the range to extrapolation; "" if they do not."""
    highest = max(point.mass_mg for point in points)
    if highest >= REACH_SHARE * max_mg:
        return ""
    return (
        f"the greatest mass is {highest / max_mg:.0%} of Max: what lies above "
        f"{show_mass(highest, interval_mg)} is extrapolated, and an error of the points grows with "
        "it. A mass of half of Max or more makes it a measurement."
    )


def check_mass_mg(points: Sequence[Point]) -> float:
    """A mass worth weighing to check: the middle of the widest gap between points."""
    masses = sorted(point.mass_mg for point in points)
    low, high = max(pairwise(masses), key=lambda pair: pair[1] - pair[0])
    return (low + high) / 2
