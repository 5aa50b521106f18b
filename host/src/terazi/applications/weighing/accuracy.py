# SPDX-License-Identifier: MIT
"""Errors of a scale on a cell that bows, calibrated in few points, beside class III."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field

import numpy as np

from terazi.applications.weighing.bench import ONE_Q7, REST_S, Cell, piecewise, sample_times, weigh
from terazi.applications.weighing.limits import permitted_error_e
from terazi.design import scale as design

DWELL_S = 2.5  # how long each load lies; it is read at the end


@dataclass(frozen=True)
class AccuracyExperiment:
    """All that the figures depend on. e is 1 g of 5 kg."""

    seed: int = 2026
    cell: Cell = field(default_factory=lambda: Cell(bow=2e-4))
    rate_sps: float = 80.0
    calibration_points: tuple[int, ...] = (2, 5)
    loads_g: tuple[float, ...] = (
        0.0, 20.0, 100.0, 250.0, 500.0, 1000.0, 1500.0, 2000.0, 2500.0, 3000.0, 3500.0, 4000.0,
        4500.0, 5000.0,
    )  # fmt: skip
    repeats: int = 5


def _read(weighed, count: int, values: np.ndarray) -> np.ndarray:
    """(count,) values at the end of each dwell, the last of which ends the record."""
    ends_s = weighed.t_s[-1] - DWELL_S * np.arange(count - 1, -1, -1)
    return values[np.searchsorted(weighed.t_s, ends_s + 1e-9, side="right") - 1]


def _lay(
    experiment: AccuracyExperiment,
    loads_g: Sequence[float],
    random: np.random.Generator,
    config: dict | None,
):
    """Nothing for REST_S, then each load for DWELL_S."""
    starts_s = REST_S + DWELL_S * np.arange(len(loads_g))
    t_s = sample_times(experiment.rate_sps, REST_S + DWELL_S * len(loads_g) - 0.05, random)
    load_g = piecewise(starts_s, [0.0, *loads_g])
    return weigh(experiment.cell, load_g, t_s, random, config)


def calibrated(experiment: AccuracyExperiment, points: int, random: np.random.Generator) -> dict:
    """The configuration after a calibration with as many weights, evenly from zero to Max."""
    masses_g = np.linspace(0.0, experiment.cell.max_g, points)
    weighed = _lay(experiment, masses_g, random, None)
    counts = _read(weighed, points, weighed.estimate_q7) / ONE_Q7
    return design.config(list(zip(counts.tolist(), masses_g.tolist(), strict=True)))


def errors_of(experiment: AccuracyExperiment, points: int) -> dict:
    """Errors at every load, up and down, over all repeats: calibrated anew each time."""
    loads_g = np.array(experiment.loads_g)
    course_g = np.concatenate([loads_g, loads_g[-2::-1]])
    errors_e, stable = [], []
    for repeat in range(experiment.repeats):
        random = np.random.default_rng((experiment.seed, points, repeat))
        config = calibrated(experiment, points, random)
        e_g = config["interval_mg"] / 1000.0
        weighed = _lay(experiment, course_g, random, config)
        errors_e.append((_read(weighed, len(course_g), weighed.net_g) - course_g) / e_g)
        stable.append(_read(weighed, len(course_g), weighed.stable))
    errors_e, limits_e = np.array(errors_e), permitted_error_e(loads_g / e_g)
    per_load = {}
    for load_g, limit_e in zip(loads_g, limits_e, strict=True):
        here = errors_e[:, course_g == load_g].ravel()
        per_load[f"{load_g / e_g:g}"] = {
            "mean_error_e": float(here.mean()),
            "sigma_e": float(here.std(ddof=1)),
            "worst_e": float(np.abs(here).max()),
            "limit_e": float(limit_e),
        }
    return {
        "per_load": per_load,
        "worst_e": max(each["worst_e"] for each in per_load.values()),
        "worst_mean_e": max(abs(each["mean_error_e"]) for each in per_load.values()),
        "within": all(each["worst_e"] <= each["limit_e"] for each in per_load.values()),
        "all_stable": bool(np.all(stable)),
    }


def accuracy(
    experiment: AccuracyExperiment | None = None, progress: Callable[[str], None] = lambda _: None
) -> dict:
    """What `terazi weigh static --json` tells of errors."""
    experiment = experiment or AccuracyExperiment()
    by_points = {}
    for points in experiment.calibration_points:
        progress(f"a calibration with {points} points")
        by_points[str(points)] = errors_of(experiment, points)
    return {"experiment": asdict(experiment), "by_points": by_points}
