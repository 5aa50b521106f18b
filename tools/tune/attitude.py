# SPDX-License-Identifier: MIT
"""Finds the settings of mahony.toml and rest.toml on BROAD's trials, leaving one trial out.

    ./dev run python -m tools.tune.attitude [--json] [FOLDER]

For every search all settings of its grid run over all trials, by the shipped fixed-point chain.
Then, for each trial, the setting is chosen that is best on the mean of the others, and judged on
that one: the mean of these errors is what a recording can expect that had no part in the choice.
FOLDER: trials in BROAD's format; without it, attitude/broad below TERAZI_DATA.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from terazi.applications.attitude.chain import estimate
from terazi.applications.attitude.score import attitude_errors
from terazi.applications.attitude.trials import Trial, find_trials, load_trial
from terazi.design import mahony, rest

INCLINATION, TOTAL = "inclination_rmse_deg", "total_rmse_deg"
LIMITS = ("enter_acc_m_s2", "leave_acc_m_s2", "enter_gyro_deg_s", "leave_gyro_deg_s")
Setting = dict[str, float]


@dataclass(frozen=True)
class Search:
    """A grid of settings, and by which error they are chosen.

    grid : key of mahony.toml or rest.toml -> values; "limits" scales all of rest's limits.
    """

    filter: str
    grid: dict[str, tuple[float, ...]]
    mode: int = 6
    figure: str = INCLINATION
    fixed: Setting = field(default_factory=dict)

    def settings(self) -> list[Setting]:
        """All points of the grid."""
        points = itertools.product(*self.grid.values())
        return [dict(zip(self.grid, point, strict=True)) for point in points]


SEARCHES = {
    "second order": Search(
        "second_order",
        {"tau_s": (2.0, 2.5, 2.75, 3.0, 3.25, 3.5, 4.0, 5.0), "ramp_s": (1.0, 2.0, 3.0, 4.0)},
    ),
    "linear": Search(
        "linear",
        {"kp_rad_s": (0.05, 0.07, 0.1, 0.12, 0.15, 0.2, 0.3), "ki_rad_s2": (0.0, 0.0003, 0.001)},
    ),
    "classic": Search(
        "classic",
        {"kp_rad_s": (0.05, 0.1, 0.15, 0.2, 0.3, 0.5), "ki_rad_s2": (0.0, 0.0003, 0.001, 0.003)},
    ),
    "rest": Search(
        "second_order",
        {
            "limits": (0.5, 0.75, 1.0, 1.5, 2.0),
            "still_s": (1.0, 1.5, 2.0),
            "bias_s": (5.0, 10.0, 20.0),
        },
    ),
    "heading": Search(
        "second_order",
        {"heading_tau_s": (5.0, 9.0, 12.0, 15.0, 20.0, 25.0, 30.0)},
        mode=9,
        figure=TOTAL,
    ),
}


def shipped(search: Search) -> Setting:
    """The setting that the specifications hold now."""
    tables = [mahony.spec()[search.filter], mahony.spec()["start"], mahony.spec()["field"]]
    tables += [rest.spec()["limits"], rest.spec()["times"], {"limits": 1.0}]
    return {key: next(t[key] for t in tables if key in t) for key in search.grid}


def split(setting: Setting) -> tuple[Setting, Setting]:
    """Keys of mahony.toml, keys of rest.toml."""
    limits, times = rest.spec()["limits"], rest.spec()["times"]
    of_rest = {key: value for key, value in setting.items() if key in limits or key in times}
    if "limits" in setting:
        of_rest |= {key: limits[key] * setting["limits"] for key in LIMITS}
    of_mahony = {k: v for k, v in setting.items() if k not in of_rest and k != "limits"}
    return of_mahony, of_rest


_trials: list[Trial] = []  # of this process; loaded once


def _load(paths: list[Path]) -> None:
    _trials.extend(load_trial(path) for path in paths)


def _errors(job: tuple[Search, Setting]) -> list[float]:
    """The figure of each trial under one setting; infinite if the chip's formats do not hold it."""
    search, setting = job
    of_mahony, of_rest = split(setting)
    try:
        mahony.config_at(_trials[0].rate_hz, search.filter, **of_mahony)
    except ValueError:
        return [np.inf] * len(_trials)
    found = []
    for trial in _trials:
        quats = estimate(
            trial, mode=search.mode, filter=search.filter, mahony=of_mahony, rest=of_rest
        )
        errors = attitude_errors(
            quats[trial.scored], trial.truth_wb[trial.scored], heading_is_free=search.mode == 6
        )
        found.append(asdict(errors)[search.figure])
    return found


def leave_one_out(errors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(settings, trials) errors -> for each trial the setting chosen without it, and its error."""
    lawful = np.isfinite(errors).all(axis=1, keepdims=True)
    known = np.where(lawful, errors, 0.0)
    others = np.where(lawful, known.sum(axis=1, keepdims=True) - known, np.inf)
    chosen = others.argmin(axis=0)
    return chosen, errors[chosen, np.arange(errors.shape[1])]


def run(search: Search, paths: list[Path], pool: ProcessPoolExecutor) -> dict:
    """What one search found."""
    settings = search.settings()
    errors = np.array(list(pool.map(_errors, [(search, each) for each in settings])))
    chosen, left_out = leave_one_out(errors)
    means = errors.mean(axis=1)
    now = shipped(search)
    votes = Counter(chosen.tolist())
    marginals = {
        key: {
            value: round(min(m for m, s in zip(means, settings, strict=True) if s[key] == value), 4)
            for value in values
        }
        for key, values in search.grid.items()
    }
    report = {
        "figure": search.figure,
        "axes": search.mode,
        "best_mean_by_key": marginals,
        "best": {"setting": settings[means.argmin()], "mean": round(means.min(), 4)},
        "left_out": {
            "mean": round(left_out.mean(), 4),
            "worst": round(left_out.max(), 4),
            "chosen": [{"setting": settings[at], "times": n} for at, n in votes.most_common()],
        },
        "shipped": {"setting": now},
    }
    if now in settings:
        row = errors[settings.index(now)]
        report["shipped"] |= {"mean": round(row.mean(), 4), "worst": round(row.max(), 4)}
    return report


def show(name: str, report: dict, console: Console) -> None:
    table = Table(title=f"{name}: {report['axes']} axes, {report['figure']}", title_justify="left")
    table.add_column("key")
    table.add_column("best mean that a value reaches")
    for key, row in report["best_mean_by_key"].items():
        table.add_row(key, "   ".join(f"{value:g}: {mean:.3f}" for value, mean in row.items()))
    console.print(table)
    left_out = report["left_out"]
    console.print(f"best of all  {report['best']['mean']:.4f}  {report['best']['setting']}")
    console.print(f"left out     {left_out['mean']:.4f}  worst {left_out['worst']:.3f}")
    for choice in left_out["chosen"]:
        console.print(f"             chosen {choice['times']} times: {choice['setting']}")
    held = report["shipped"]
    figures = f"{held['mean']:.4f}  worst {held['worst']:.3f}" if "mean" in held else "not searched"
    console.print(f"shipped      {figures}  {held['setting']}\n")


def main() -> int:
    """Command line, see above."""
    parser = argparse.ArgumentParser(prog="tune.attitude", description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="one JSON object, nothing else")
    parser.add_argument("folder", nargs="?", type=Path)
    options = parser.parse_args()
    data = os.environ.get("TERAZI_DATA")
    if options.folder is None and not data:
        print("tune: name a folder of trials, or set TERAZI_DATA", file=sys.stderr)
        return 2
    paths = find_trials(options.folder or Path(data) / "attitude" / "broad")
    if len(paths) < 3:
        print("tune: to leave one out, three trials are needed", file=sys.stderr)
        return 2
    with ProcessPoolExecutor(initializer=_load, initargs=(paths,)) as pool:
        reports = {}
        console = Console(highlight=False)
        for name, search in SEARCHES.items():
            reports[name] = run(search, paths, pool)
            if not options.json:
                show(name, reports[name], console)
    if options.json:
        print(json.dumps(reports))
    return 0


if __name__ == "__main__":
    sys.exit(main())
