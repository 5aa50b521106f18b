# SPDX-License-Identifier: MIT
"""Float64 truth for scale.c."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from terazi.design import scale as design

STABLE, AT_ZERO, OVER, UNDER, STEPPED, ZEROED = 1, 2, 4, 8, 16, 32
MASS_BUDGET_MG = 1.0  # |C - model| of the calibrated mass, shared_c/notes/scale.md
LOAD_BUDGET_MG = 2.75  # of the load above zero, which may have been tracked
TRACK_S = 2.0**17 * 1e-6
COUNT_RAIL = 2.0**30 / design.ONE_COUNT_Q7
MASS_RAIL_MG = 2.0**30


def mass_mg(counts, points: Sequence[tuple[float, float]]):
    """(n,) float64 mass in mg of filtered counts, by lines through the calibration's points.

    points : (counts, mg), counts rising or falling. The first and the last line go on outside.
    The C rounds slopes down and the mass to a milligram: within MASS_BUDGET_MG.
    """
    x, m = (np.array(each, dtype=np.float64) for each in zip(*points, strict=True))
    sign = 1.0 if x[1] > x[0] else -1.0
    limited = np.clip(np.asarray(counts, dtype=np.float64), -COUNT_RAIL, COUNT_RAIL)
    at = np.clip(np.searchsorted(sign * x, sign * limited, side="right") - 1, 0, len(x) - 2)
    slope = (m[at + 1] - m[at]) / (x[at + 1] - x[at])
    return np.clip(m[at] + (limited - x[at]) * slope, -MASS_RAIL_MG, MASS_RAIL_MG)


def division_mg(config: Mapping) -> float:
    """The display's d."""
    unit = design.unit_mg(design.spec()["unit"][config["unit"]])
    return float(unit * Fraction(config["digit"], 10 ** config["decimals"]))


@dataclass(frozen=True)
class ScaleResult:
    """What the scale gives after each sample."""

    load_mg: np.ndarray  # (n,) float64
    shown: np.ndarray  # (n,) int64, in 10^-decimals of the unit
    flags: np.ndarray  # (n,) uint8
    steps: list[tuple[float, float, float]]  # left at s, from mg, to mg
    margin_mg: float  # least distance of a decision from its limit


class _Scale:
    def __init__(self, config: Mapping) -> None:
        self.config = config
        self.division_mg = division_mg(config)
        self.zero = self.initial = 0.0
        self.low = self.high = self.since_s = self.left_s = self.tracking_s = 0.0
        self.begun = self.steady = False
        self.settled: float | None = None
        self.steps: list[tuple[float, float, float]] = []
        self.divisions = 0
        self.flags = 0
        self.margin = np.inf

    def decide(self, value: float, limit: float) -> bool:
        """Whether value exceeds limit."""
        self.margin = min(self.margin, abs(value - limit))
        return value > limit

    def unsettle(self, time_s: float) -> None:
        if self.steady:
            self.left_s = time_s
        self.steady, self.tracking_s = False, 0.0

    def watch(self, mass: float, time_s: float) -> None:
        low, high = min(self.low, mass), max(self.high, mass)
        if not self.begun or self.decide(high - low, self.config["stable_band_mg"]):
            self.unsettle(time_s)
            self.low = self.high = mass
            self.since_s, self.begun = time_s, True
            return
        self.low, self.high = low, high
        if not self.steady and time_s - self.since_s >= self.config["stable_us"] * 1e-6 - 1e-9:
            self.settle(mass)

    def settle(self, mass: float) -> None:
        self.steady = True
        if self.settled is None:
            wanted = self.config["options"] & design.OPTIONS["initial_zero"]
            if wanted and not self.decide(abs(mass), 0.1 * self.config["max_mg"]):
                self.zero = self.initial = mass
                self.flags |= ZEROED
        elif self.decide(abs(mass - self.settled), self.config["step_mg"]):
            self.flags |= STEPPED
            self.steps.append((self.left_s, self.settled - self.zero, mass - self.zero))

    def track(self, mass: float, elapsed_s: float) -> None:
        e, load = self.config["interval_mg"], mass - self.zero
        wanted = self.config["options"] & design.OPTIONS["track_zero"]
        if not wanted or self.decide(abs(load), e / 2):
            self.tracking_s = 0.0
            return
        self.tracking_s += elapsed_s
        if self.tracking_s < TRACK_S - 1e-9:
            return
        self.tracking_s = 0.0
        span = 0.02 * self.config["max_mg"]
        wanted = self.zero + np.clip(load, -e / 16, e / 16)
        self.zero = float(np.clip(wanted, self.initial - span, self.initial + span))

    def display(self, load: float) -> None:
        there = load / self.division_mg
        held = 0.5 + self.config["hysteresis_q8"] / 256
        off = abs(there - self.divisions) * self.division_mg
        if self.decide(off, held * self.division_mg):
            to_edge = abs(there - np.floor(there) - 0.5)
            self.margin = min(self.margin, to_edge * self.division_mg)
            self.divisions = int(np.floor(there + 0.5))


def scale(counts, time_s, config: Mapping) -> ScaleResult:
    """Float64 truth for ``scale_update`` over a run without commands.

    counts : (n,) float64 filtered counts; time_s : (n,) float64, rising, from 0 on.
    config : fields of scale_config_t.

    Nothing is rounded but what is shown. The C lies within LOAD_BUDGET_MG of load_mg, and decides
    and shows the same where margin_mg is above twice that: shared_c/notes/scale.md.
    """
    used = slice(0, config["points"])
    x = np.array(config["point_counts_q7"][used]) / design.ONE_COUNT_Q7
    masses = mass_mg(counts, list(zip(x, config["point_mass_mg"][used], strict=True)))
    one, e, last_s = _Scale(config), config["interval_mg"], 0.0
    loads, shown, flags = np.zeros(len(masses)), np.zeros(len(masses), int), []
    for n, (mass, now_s) in enumerate(zip(masses.tolist(), np.asarray(time_s), strict=True)):
        elapsed_s, last_s = now_s - last_s, now_s
        if elapsed_s > config["gap_us"] * 1e-6 + 1e-9:
            one.unsettle(now_s - elapsed_s)
            one.begun = False
        one.flags &= ZEROED
        was_steady = one.steady
        one.watch(mass, now_s)
        one.settled = mass if one.steady else one.settled
        if was_steady and one.steady:
            one.track(mass, elapsed_s)
        loads[n] = load = mass - one.zero
        if one.decide(load, config["max_mg"] + 9 * e):
            one.flags |= OVER
        elif one.decide(-load, config["under_mg"]):
            one.flags |= UNDER
        else:
            one.flags |= STABLE if one.steady else 0
            one.flags |= 0 if one.decide(abs(load), e / 4) else AT_ZERO
        one.display(load)
        shown[n] = one.divisions * config["digit"]
        flags.append(one.flags)
    return ScaleResult(loads, shown, np.array(flags, np.uint8), one.steps, float(one.margin))
