# SPDX-License-Identifier: MIT
"""How soon the stable flag stands after a step, and whether it ever lies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field

import numpy as np

from terazi.applications.weighing.bench import REST_S, Cell, Weighed, piecewise, sample_times, weigh
from terazi.design import scale as design

AFTER_S = 3.0  # how long a step is watched
MOVING_S = 20.0  # how long a load moves


@dataclass(frozen=True)
class Swing:
    """A pan's damped oscillation after a step, as a share of the step."""

    hz: float
    damping: float  # of the critical
    share: float

    def at(self, since_s: np.ndarray) -> np.ndarray:
        """(n,) of the step, 0 before it."""
        omega, t_s = 2 * np.pi * self.hz, np.maximum(since_s, 0.0)
        swing = np.exp(-self.damping * omega * t_s)
        swing *= np.cos(omega * np.sqrt(1 - self.damping**2) * t_s)
        return np.where(since_s >= 0, -self.share * swing, 0.0)


@dataclass(frozen=True)
class StabilityExperiment:
    """All that the figures depend on. e is 1 g of 5 kg."""

    seed: int = 2026
    cell: Cell = field(default_factory=Cell)
    rates_sps: tuple[float, ...] = (78.0, 80.0, 92.0)
    steps_g: tuple[tuple[float, float], ...] = (
        (0.0, 2.0),
        (0.0, 5.0),
        (0.0, 20.0),
        (0.0, 200.0),
        (0.0, 5000.0),
        (5000.0, 0.0),
        (1005.0, 1000.0),
        (3000.0, 2500.0),
    )
    repeats: int = 20
    swings: tuple[Swing | None, ...] = (None, Swing(15.0, 0.15, 0.1), Swing(20.0, 0.2, 0.3))
    ramps_e_s: tuple[float, ...] = (0.02, 0.1, 0.3, 0.6, 0.9, 1.2, 2.0, 3.0, 5.0, 10.0, 50.0, 500.0)
    creeps_e: tuple[float, ...] = (2.0, 20.0, 500.0)  # left of an exponential, time constant 5 s
    sways: tuple[tuple[float, float], ...] = (  # amplitude in e, Hz
        (0.6, 0.05),
        (0.6, 0.3),
        (0.7, 1.0),
        (1.0, 0.1),
        (1.0, 2.0),
        (3.0, 0.05),
        (3.0, 0.3),
        (5.0, 3.0),
    )


@dataclass(frozen=True)
class StepFigures:
    """Of one kind of step over all repeats and rates."""

    median_s: float
    worst_s: float  # from the step until the flag stands for good
    late_samples: int  # flagged stable after the step, until the flag fell
    false_samples: int  # flagged stable while more than 1 e off the truth


@dataclass(frozen=True)
class MovingFigures:
    """Of one moving load over all repeats and rates."""

    stable_share: float
    off_e: float  # furthest from the truth while flagged
    moved_e: float  # most that the truth has moved within the time that a flag stands for


def claims(weighed: Weighed, stable_s: float) -> list[tuple[int, int]]:
    """What each flag stands for, [begin, end): from stable_s before it rose until it fell."""
    edges = np.diff(np.concatenate([[0], weighed.stable.astype(np.int8), [0]]))
    rose, fell = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    begins = np.searchsorted(weighed.t_s, weighed.t_s[rose] - stable_s + 1e-6)
    return list(zip(begins.tolist(), fell.tolist(), strict=True))


def _off_e(weighed: Weighed, e_g: float) -> np.ndarray:
    """Distance from the truth in e where the flag stands, else 0."""
    return np.where(weighed.stable, np.abs(weighed.mass_g - weighed.truth_g), 0.0) / e_g


def one_step(
    experiment: StabilityExperiment,
    rate_sps: float,
    step_g: tuple[float, float],
    swing: Swing | None,
    random: np.random.Generator,
) -> tuple[float, int, int]:
    """Seconds until the flag stands for good (inf: never), late samples, false samples."""
    from_g, to_g = step_g
    at_s = 2 * REST_S
    t_s = sample_times(rate_sps, at_s + AFTER_S, random)
    put_on = piecewise([REST_S, at_s], [0.0, from_g, to_g])

    def load_g(t_s: np.ndarray) -> np.ndarray:
        moved = put_on(t_s)
        return moved if swing is None else moved + (to_g - from_g) * swing.at(t_s - at_s)

    weighed = weigh(experiment.cell, load_g, t_s, random)
    e_g = design.config()["interval_mg"] / 1000.0
    after = int(np.searchsorted(t_s, at_s))
    stable = weighed.stable[after:]
    if not weighed.stable[after - 1] or not stable[-1]:
        return np.inf, 0, 0
    unsettled = np.flatnonzero(~stable)
    if not len(unsettled):
        return np.inf, len(stable), 0
    stands = unsettled[-1] + 1
    false = int((_off_e(weighed, e_g)[after:] > 1.0).sum())
    return float(t_s[after + stands] - at_s), int(unsettled[0]), false


def step_figures(
    experiment: StabilityExperiment, step_g: tuple[float, float], swing: Swing | None
) -> StepFigures:
    """Every rate, every repeat."""
    runs = [
        one_step(
            experiment,
            rate_sps,
            step_g,
            swing,
            np.random.default_rng((experiment.seed, repeat, round(rate_sps), *map(int, step_g))),
        )
        for rate_sps in experiment.rates_sps
        for repeat in range(experiment.repeats)
    ]
    times_s, late, false = zip(*runs, strict=True)
    return StepFigures(float(np.median(times_s)), max(times_s), max(late), sum(false))


def moving_loads(experiment: StabilityExperiment) -> dict[str, Callable]:
    """Name -> gram over the seconds since the movement began."""
    ramps = {
        f"ramp of {sign * rate:g} e/s": lambda t, v=sign * rate: 2000.0 + v * t
        for rate in experiment.ramps_e_s
        for sign in (1, -1)
    }
    creeps = {
        f"creep of {left:g} e": lambda t, left=left: 2000.0 + left * (1 - np.exp(-t / 5.0))
        for left in experiment.creeps_e
    }
    sways = {
        f"sway of {size:g} e at {hz:g} Hz": lambda t, a=size, hz=hz: (
            2000.0 + a * np.sin(2 * np.pi * hz * t)
        )
        for size, hz in experiment.sways
    }
    return ramps | creeps | sways


def moving_figures(experiment: StabilityExperiment, moving: Callable, index: int) -> MovingFigures:
    """A load that rests, then moves."""
    config = design.config(max_g=30_000.0)  # so that no ramp leaves the range
    stable_s, e_g = config["stable_us"] * 1e-6, config["interval_mg"] / 1000.0
    shares, off_e, moved_e = [], [0.0], [0.0]
    for rate_sps in experiment.rates_sps:
        random = np.random.default_rng((experiment.seed, index, round(rate_sps)))
        t_s = sample_times(rate_sps, REST_S + MOVING_S, random)

        def load_g(t_s: np.ndarray) -> np.ndarray:
            return moving(np.maximum(t_s - REST_S, 0.0)) * e_g

        weighed = weigh(experiment.cell, load_g, t_s, random, config)
        shares.append(weighed.stable[t_s >= REST_S].mean())
        off_e.append(_off_e(weighed, e_g).max())
        moved_e += [
            np.ptp(weighed.truth_g[begin:end]) / e_g for begin, end in claims(weighed, stable_s)
        ]
    return MovingFigures(float(np.mean(shares)), float(max(off_e)), float(max(moved_e)))


def stability(
    experiment: StabilityExperiment | None = None, progress: Callable[[str], None] = lambda _: None
) -> dict:
    """What `terazi weigh static --json` tells of the flag."""
    experiment = experiment or StabilityExperiment()
    steps = {}
    for swing in experiment.swings:
        name = "clean" if swing is None else f"swing {swing.hz:g} Hz"
        progress(f"steps, {name}")
        steps[name] = {
            f"{from_g:g} -> {to_g:g} g": asdict(step_figures(experiment, (from_g, to_g), swing))
            for from_g, to_g in experiment.steps_g
        }
    progress("loads that move")
    moving = {
        name: asdict(moving_figures(experiment, load, index))
        for index, (name, load) in enumerate(moving_loads(experiment).items())
    }
    clean = steps.get("clean", {}).values()
    return {
        "experiment": asdict(experiment),
        "steps": steps,
        "moving": moving,
        "worst_s": max((each["worst_s"] for each in clean), default=None),
        "off_e": max(each["off_e"] for each in moving.values()),
        "moved_e": max(each["moved_e"] for each in moving.values()),
    }
