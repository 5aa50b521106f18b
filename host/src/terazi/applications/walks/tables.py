# SPDX-License-Identifier: MIT
"""The documents' tables, again: on simulated walks of the same shape, whose truth is exact, and on
the one record that is at hand. Stated as what they are: their own recordings are not.

Article (2019): corridor and stairs, 26 m: error in X 5.7 % and drift in Y 8 m without, 1.15 % and
about 0 with heuristic drift elimination, on the complementary navigator.
Thesis (2022): squares of 10 m and circles of 5 m radius: 2.23 m standard, 0.956 m LSTM; stairs 2.27
and 0.98 m.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from terazi.applications.walks import simulator
from terazi.applications.walks.complementary import ComplementarySettings
from terazi.applications.walks.estimate import LEARNT, Options, Result, estimate
from terazi.applications.walks.formats import load_walk
from terazi.applications.walks.navigator import KalmanSettings
from terazi.applications.walks.networks import NAMED
from terazi.applications.walks.score import path_errors
from terazi.errors import CannotRead

SEEDS = range(1, 6)
# A gyroscope as the article's was after its calibration: what drifts is left to the elimination.
DRIFTING = replace(simulator.Mems(), gyro_bias_rad_s=np.radians(0.3))
PLAN_M = 26.0


@dataclass(frozen=True)
class Shown:
    """One table."""

    name: str
    title: str
    headings: Sequence[str]
    rows: Sequence[Sequence]
    notes: Sequence[str] = ()

    def plain(self) -> list[dict]:
        """Rows by their headings."""
        return [dict(zip(self.headings, row, strict=True)) for row in self.rows]


def tables(
    folder: Path | None,
    weights: Path | None,
    *,
    progress: Callable[[float, str], None] | None = None,
) -> list[Shown]:
    """All tables; folder: of the article-like record, or None; weights: of one more detector.

    progress is told the share done, and what comes next.
    """
    runs = _thesis_runs(weights)
    tally = _Tally(2 * len(SEEDS) + (6 if folder else 0) + 3 * len(SEEDS) * len(runs), progress)
    found = [corridor_table(tally)]
    if folder is not None:
        found.append(record_table(folder, tally))
    return [*found, thesis_table(runs, tally)]


class _Tally:
    """Counts walks for whoever watches."""

    def __init__(self, total: int, progress: Callable[[float, str], None] | None):
        self._total, self._progress, self._begun = total, progress, 0

    def begins(self, words: str) -> None:
        if self._progress:
            self._progress(self._begun / self._total, words)
        self._begun += 1


def _article(eliminate: bool, bias: str) -> Options:
    return Options(
        navigator="complementary",
        eliminate_drift=eliminate,
        roll_share=0.0,
        complementary=ComplementarySettings(bias=bias),
    )


def _end_in_first_direction(result: Result) -> tuple[float, float]:
    """x and y of the end, x along the first five strides: nobody knows another north."""
    strides = result.strides
    along = strides.vectors_m[:5, :2].sum(axis=0)
    along = along / np.linalg.norm(along)
    end = (result.path.pos_w_m[-1] - result.path.pos_w_m[0])[:2]
    return float(end @ along), float(along[0] * end[1] - along[1] * end[0])


def corridor_table(tally: _Tally) -> Shown:
    """Simulated: the corridor runs along x."""
    rows = []
    for eliminate in (False, True):
        errors_x, drifts_y, words = [], [], 0
        for seed in SEEDS:
            tally.begins("corridor")
            walk = simulator.simulate(simulator.corridor(PLAN_M), seed=seed, mems=DRIFTING)
            result = estimate(walk, _article(eliminate, "none"))
            x, y = _end_in_first_direction(result)
            errors_x.append(100 * abs(x - PLAN_M) / PLAN_M)
            drifts_y.append(abs(y))
            words += any("applied" in note for note in result.walk.notes)
        rows.append(
            ["with" if eliminate else "without", np.mean(errors_x), np.mean(drifts_y), f"{words}"]
        )
    return Shown(
        "article_simulated",
        f"Corridor of {PLAN_M:g} m with stairs, simulated, {len(SEEDS)} seeds, complementary",
        ("drift elimination", "X error %", "Y drift m", "applied"),
        rows,
        ["The article: 5.7 % and 8 m without, 1.15 % and about 0 m with."],
    )


def record_table(folder: Path, tally: _Tally) -> Shown:
    """The public record that is nearest to the article's; no truth is documented."""
    paths = sorted(folder.glob("stairsAndCorridor*.csv"))
    if not paths:
        raise CannotRead(f"{folder}: holds no stairsAndCorridor*.csv")
    walk = load_walk(paths[0])
    rows = []
    for navigator in ("complementary", "kalman"):
        for bias in ("none", "start") if navigator == "complementary" else ("states",):
            for eliminate in (False, True):
                tally.begins(walk.name)
                options = Options(
                    navigator=navigator,
                    eliminate_drift=eliminate,
                    complementary=ComplementarySettings(bias=bias if bias != "states" else "rest"),
                )
                result = estimate(walk, options)
                x, y = _end_in_first_direction(result)
                z = float(result.path.pos_w_m[-1, 2] - result.path.pos_w_m[0, 2])
                rows.append([navigator, bias, "with" if eliminate else "without", x, y, z])
    return Shown(
        "article_record",
        f"{walk.name}: where it ends, x along its first five strides",
        ("navigator", "gyroscope's bias", "drift elimination", "x m", "y m", "z m"),
        rows,
        [
            "No truth is documented; the building measures about 26 m x 8 m x 3 m.",
            "A path that is turned by its drift alone would end beside the corridor.",
        ],
    )


def _thesis_runs(weights: Path | None) -> dict[str, Options]:
    """What is compared. As in the thesis, nothing but zero velocity helps: nothing of the future,
    no level floors, no rolling foot; in the last one everything does, as `terazi walk` has it."""
    alone = {"causal": True, "roll_share": 0.0, "kalman": KalmanSettings(level_gate_m=0.0)}
    runs = {
        "SHOE, fixed threshold (standard)": Options(detector="shoe", **alone),
        "LSTM, 6 x 80": Options(detector=LEARNT, weights=NAMED["lstm"], **alone),
        "GRU, 8 cells": Options(detector=LEARNT, weights=NAMED["gru8"], **alone),
    }
    if weights is not None:
        runs[weights.name] = Options(detector=LEARNT, weights=weights, **alone)
    return {**runs, "default": Options(roll_share=0.0)}


def thesis_table(runs: dict[str, Options], tally: _Tally) -> Shown:
    """Simulated squares, circles and stairs; the simulated foot does not roll."""
    routes = {
        "square 10 m": simulator.square(10.0, rounds=2),
        "circle 5 m": simulator.circle(5.0, rounds=3),
        "stairs": [*simulator.stand(3), *simulator.staircase(20), *simulator.stand(2)],
    }
    rows = []
    for route, pieces in routes.items():
        walks = [simulator.simulate(pieces, seed=seed) for seed in SEEDS]
        row: list = [route]
        for name, options in runs.items():
            errors_m = []
            for walk in walks:
                tally.begins(f"{route}: {name}")
                found = estimate(walk, options).path.pos_w_m
                errors_m.append(path_errors(walk, found).rmse_3d_m)
            row.append(float(np.mean(errors_m)))
        rows.append(row)
    return Shown(
        "thesis_simulated",
        f"Squares, circles, stairs, simulated, {len(SEEDS)} seeds: 3-D rms, m",
        ("route", *runs),
        rows,
        [
            "The thesis, on its own recordings: squares and circles 2.23 m standard, 0.956 m LSTM; "
            "stairs 2.27 m and 0.98 m.",
            "The simulated foot bears a better sensor and stands stiller than theirs. All but the "
            "default: zero velocity alone helps, nothing of the future, no level floors.",
        ],
    )
