# SPDX-License-Identifier: MIT
"""Float64 truth for scale.c."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np

from terazi.design import scale as design

STABLE, AT_ZERO, OVER, UNDER, STEPPED, ZEROED = 1, 2, 4, 8, 16, 32
MASS_BUDGET_MG = 1.0  # |C - model| of the calibrated mass, shared_c/notes/scale.md
LOAD_BUDGET_MG = 2.75  # of the load above zero, which may have been tracked
SPREAD_BUDGET = 3.5  # grains, of how far estimates lie apart
REACH_BUDGET = 12.0  # grains, of how far a measurement may lie off
LAG_BUDGET = 4.0  # grains, of the mean of how far they are ahead
APART, LEAP_MAX = (-2048.0, 2047.0), 4095.0  # grains
TRACK_S = 2.0**18 * 1e-6
BITS_31 = (-(2.0**30), 2.0**30 - 1)  # counts Q7 and masses


def mass_mg(counts, points: Sequence[tuple[float, float]]):
    """(n,) float64 mass in mg of filtered counts, by lines through the calibration's points.

    points : (counts, mg), counts rising or falling. The first and the last line go on outside.
    The C rounds slopes down and the mass to a milligram: within MASS_BUDGET_MG.
    """
    x, m = (np.array(each, dtype=np.float64) for each in zip(*points, strict=True))
    sign = 1.0 if x[1] > x[0] else -1.0
    limited = np.clip(
        np.asarray(counts, dtype=np.float64), *(np.array(BITS_31) / design.ONE_COUNT_Q7)
    )
    at = np.clip(np.searchsorted(sign * x, sign * limited, side="right") - 1, 0, len(x) - 2)
    slope = (m[at + 1] - m[at]) / (x[at + 1] - x[at])
    return np.clip(m[at] + (limited - x[at]) * slope, *BITS_31)


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
    def __init__(self, config: Mapping, steepest: float) -> None:
        self.config, self.steepest = config, steepest  # mg a count
        band = config["stable_band_mg"] / steepest  # counts
        grain_q7 = 2.0 ** max(np.floor(np.log2(max(band * design.ONE_COUNT_Q7, 1.0))) - 7, 0)
        self.grain = grain_q7 / design.ONE_COUNT_Q7
        self.band = band / self.grain
        self.division_mg = division_mg(config)
        self.zero = self.initial = 0.0
        self.low = self.high = self.since_s = self.left_s = self.now_s = 0.0
        self.anchor = self.mass = self.raw = self.rough = self.lag = 0.0
        self.begun = self.steady = False
        self.settled: float | None = None
        self.steps: list[tuple[float, float, float]] = []
        self.divisions = 0
        self.flags = 0
        self.margin = np.inf

    def decide(self, value: float, limit: float, slack: float = 0.0) -> bool:
        """Whether value exceeds limit, which the C knows to within slack."""
        self.margin = min(self.margin, abs(value - limit) - slack)
        return value > limit

    def decide_grains(self, value: float, limit: float, slack: float) -> bool:
        """The same in grains, which weigh as the steepest line says."""
        self.margin = min(self.margin, (abs(value - limit) - slack) * self.grain * self.steepest)
        return value > limit

    def stands(self, counts: float, raw: float) -> bool:
        """In grains. The C cuts positions, and what it makes of them, off to whole ones."""
        at, raw = (
            float(np.clip((each - self.anchor) / self.grain, *APART)) for each in (counts, raw)
        )
        stable_s = self.config["stable_us"] * 1e-6 - 1e-9
        early = not self.steady and self.now_s - self.since_s < stable_s / 4
        wide, reach = max(self.band, self.rough), self.band + max(0.75 * self.band, 4 * self.rough)
        leap = LEAP_MAX if raw in APART else abs(raw - self.raw)
        self.rough += (min(leap, 1.5 * self.rough + 4) - self.rough) / 16
        self.raw = raw
        self.lag += (np.clip(raw - at, -wide, wide) - self.lag) / 8
        self.low, self.high = min(self.low, at), max(self.high, at)
        spread, allowed = self.high - self.low, self.band * (0.5 if early else 1.0)
        apart = max(raw - self.low, self.high - raw)
        stands = self.begun and not self.decide_grains(
            spread, 1.5 * self.band if self.steady else allowed, SPREAD_BUDGET
        )
        if stands:
            beyond = self.decide_grains(apart, reach, REACH_BUDGET)
            behind = not early and self.decide_grains(abs(self.lag), wide / 2, LAG_BUDGET)
            stands = not (beyond or behind)
        if not stands:
            self.low = self.high = 0.0
            self.raw = raw - at
        return stands

    def watch(self, counts: float, raw: float, mass: float, now_s: float) -> None:
        if now_s - self.now_s > self.config["gap_us"] * 1e-6 + 1e-9:
            self.begun = False
        self.now_s = now_s
        if not self.stands(counts, raw):
            if self.steady:
                self.left_s, self.settled = now_s, self.mass
            self.steady, self.begun = False, True
            self.anchor, self.since_s = counts, now_s
        self.mass = mass
        stood_s = now_s - self.since_s
        if self.steady:
            if stood_s >= TRACK_S - 1e-9:
                self.track(mass)
        elif stood_s >= self.config["stable_us"] * 1e-6 - 1e-9:
            self.settle(mass)

    def settle(self, mass: float) -> None:
        self.steady, self.since_s = True, self.now_s
        if self.settled is None:
            wanted = self.config["options"] & design.OPTIONS["initial_zero"]
            if wanted and not self.decide(abs(mass), 0.1 * self.config["max_mg"]):
                self.zero = self.initial = mass
                self.flags |= ZEROED
        elif self.decide(abs(mass - self.settled), self.config["step_mg"]):
            self.flags |= STEPPED
            self.steps.append((self.left_s, self.settled - self.zero, mass - self.zero))
        self.settled = mass

    def track(self, mass: float) -> None:
        e, load = self.config["interval_mg"], mass - self.zero
        wanted = self.config["options"] & design.OPTIONS["track_zero"]
        self.since_s = self.now_s
        if wanted and not self.decide(abs(load), e / 2):
            span = 0.02 * self.config["max_mg"]
            moved = self.zero + float(np.clip(load, -e / 8, e / 8))
            if not self.decide(abs(moved - self.initial), span):
                self.zero = moved

    def display(self, load: float) -> None:
        there = load / self.division_mg
        held = 0.5 + self.config["hysteresis_q8"] / 256
        off = abs(there - self.divisions) * self.division_mg
        if self.decide(off, held * self.division_mg):
            to_edge = abs(there - np.floor(there) - 0.5)
            self.margin = min(self.margin, to_edge * self.division_mg)
            self.divisions = int(np.floor(there + 0.5))


def scale(counts, time_s, config: Mapping, raw=None) -> ScaleResult:
    """Float64 truth for ``scale_update`` over a run without commands.

    counts : (n,) float64 filtered counts; time_s : (n,) float64, rising, from 0 on.
    config : fields of scale_config_t.
    raw : (n,) float64 counts before the filters; None: the counts.

    Nothing is rounded but what is shown. The C lies within LOAD_BUDGET_MG of load_mg, and decides
    and shows the same where margin_mg is above twice that: shared_c/notes/scale.md.
    """
    used = slice(0, config["points"])
    x = np.array(config["point_counts_q7"][used]) / design.ONE_COUNT_Q7
    points = list(zip(x, config["point_mass_mg"][used], strict=True))
    masses = mass_mg(counts, points).tolist()
    counts = np.clip(counts, *(np.array(BITS_31) / design.ONE_COUNT_Q7))
    raws = counts if raw is None else np.asarray(raw)
    slopes = [(m1 - m0) / abs(x1 - x0) for (x0, m0), (x1, m1) in pairwise(points)]
    one, e = _Scale(config, max(slopes)), config["interval_mg"]
    loads, shown, flags = np.zeros(len(masses)), np.zeros(len(masses), int), []
    samples = zip(counts.tolist(), raws.tolist(), masses, np.asarray(time_s).tolist(), strict=True)
    for n, (each, raw_counts, mass, now_s) in enumerate(samples):
        one.flags &= ZEROED
        one.watch(each, raw_counts, mass, now_s)
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
