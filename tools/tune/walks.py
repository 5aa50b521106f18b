# SPDX-License-Identifier: MIT
"""How good the settings of `terazi walk` are, on walks that had no part in choosing them.

    ./dev run python -m tools.tune.walks [--json] [--search N] [--seed S] [FOLDER ...]

What is chosen: the adaptive detector's thresholds, in the end and at once, and the Kalman filter's
sigmas; one setting for all walks. By what: the sum over groups of walks of their mean error over
what it may be. Groups: walks under cameras (2-D), of these stairs, ladder and crawling (3-D, names
that begin with 2018), footprints (2-D), footprints without the standstill that they begin with
(copies from where the foot first moves), and records without truth (closure).

Told are the shipped setting's errors, recorded and causal, and what can be expected of others'
walks: in each group every second walk chooses a setting and the others are judged by it, both ways
round. Without --search it is chosen from a few that are drawn at random around START, a guess made
before any walk was seen; with it, by N steps of a random search from there. Chosen by causal paths,
which recorded ones do not leave by a centimetre and which are found faster; judged by recorded
ones. Nothing is taken from the shipped setting.
FOLDER: walks; without it, vicon, footprints and xio_gait below TERAZI_DATA.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from terazi.applications.walks.detectors import (
    ADAPTIVE_BATCH,
    ADAPTIVE_CAUSAL,
    AdaptiveShoe,
    adaptive_shoe_detector,
)
from terazi.applications.walks.estimate import ROLL_SHARE
from terazi.applications.walks.navigator import KalmanSettings, kalman, rolled
from terazi.applications.walks.record import Truth, Walk
from terazi.applications.walks.score import Errors, path_errors
from tools.tune.recorded import recorded_walks

FOLDERS = ("vicon", "footprints", "xio_gait")
LIMITS_M = {"cameras": 0.08, "stairs": 0.45, "footprints": 0.5, "unrested": 0.7, "loops": 0.10}
STAIRS = "2018"
MOVES_RAD_S, BEFORE_S = 0.5, 0.15  # where an unrested copy begins
CANDIDATES, SPREAD = 12, 0.4
STEPS_OF = 3  # settings that a step of the search changes, at most

Setting = dict[str, float]

RANGES: dict[str, tuple[float, float]] = {
    "window_s": (0.01, 0.06),
    "m_s2_per_rad_s": (3.0, 40.0),
    "near_s": (0.6, 1.4),
    "more": (1.05, 2.0),
    "low_rad_s": (0.05, 0.35),
    "high_rad_s": (0.8, 4.0),
    "once_near_s": (0.6, 2.0),
    "once_more": (1.05, 3.0),
    "vel_sigma_m_s": (0.01, 0.2),
    "vel_doubt": (0.1, 20.0),
    "rate_sigma_rad_s": (0.003, 0.1),
    "stance_rate_sigma_rad_s": (0.1, 2.0),
    "standstill_s": (0.2, 1.2),
    "standstill_rad_s": (0.008, 0.05),
    "level_sigma_m": (0.002, 0.03),
    "level_gate_m": (0.04, 0.08),
    "level_after_s": (0.01, 0.08),
    "attitude_noise_rad": (0.001, 0.02),
    "velocity_noise_m_s": (0.004, 0.2),
    "gyro_bias_noise_rad_s": (1e-6, 3e-4),
    "acc_bias_noise_m_s2": (1e-5, 1e-2),
    "gyro_bias_sigma_rad_s": (0.001, 0.02),
    "acc_bias_sigma_m_s2": (0.02, 0.6),
    "align_s": (0.1, 0.4),
}
"""Of each setting that is searched."""

START: Setting = {
    **{"window_s": 0.025, "m_s2_per_rad_s": 10.0, "near_s": 1.2, "more": 1.5},
    **{"low_rad_s": 0.2, "high_rad_s": 2.0, "once_near_s": 1.2, "once_more": 1.5},
    **{"vel_sigma_m_s": 0.05, "vel_doubt": 1.0, "rate_sigma_rad_s": 0.01},
    **{"stance_rate_sigma_rad_s": 0.5, "standstill_s": 0.5, "standstill_rad_s": 0.02},
    **{"level_sigma_m": 0.01, "level_gate_m": 0.06, "level_after_s": 0.05},
    **{"attitude_noise_rad": 0.003, "velocity_noise_m_s": 0.05, "gyro_bias_noise_rad_s": 1e-5},
    **{"acc_bias_noise_m_s2": 1e-3, "gyro_bias_sigma_rad_s": 0.005, "acc_bias_sigma_m_s2": 0.1},
    **{"align_s": 0.2},
}
"""Round figures of such sensors and feet."""


@dataclass(frozen=True)
class Trial:
    """A walk, the groups that it counts in, and the half that it belongs to."""

    walk: Walk
    groups: tuple[str, ...]
    half: int


def shipped() -> Setting:
    """What `terazi walk` uses."""
    of_filter = KalmanSettings()
    values = {key: getattr(of_filter, key) for key in RANGES if hasattr(of_filter, key)}
    values |= {each.name: getattr(ADAPTIVE_BATCH, each.name) for each in fields(AdaptiveShoe)}
    return values | {"once_near_s": ADAPTIVE_CAUSAL.near_s, "once_more": ADAPTIVE_CAUSAL.more}


def errors_m(walk: Walk, setting: Setting, *, causal: bool = False) -> Errors:
    """Of one walk under one setting."""
    batch = AdaptiveShoe(**{each.name: setting[each.name] for each in fields(AdaptiveShoe)})
    once = replace(batch, near_s=setting["once_near_s"], more=setting["once_more"])
    of_filter = {key: value for key, value in setting.items() if hasattr(KalmanSettings, key)}
    detection = replace(
        adaptive_shoe_detector(walk, batch, causal=False),
        at_once=adaptive_shoe_detector(walk, once, causal=True),
    )
    path = kalman(walk, detection, KalmanSettings(**of_filter), causal=causal)
    return path_errors(walk, rolled(path, ROLL_SHARE).pos_w_m)


def unrested(walk: Walk) -> Walk:
    """A copy that begins where the foot first moves."""
    turning = np.linalg.norm(walk.gyro_b_rad_s, axis=1)
    moves = int(np.argmax(turning > MOVES_RAD_S))
    begin = max(0, moves - round(BEFORE_S * walk.rate_hz))
    truth, kept = walk.truth, walk.truth.at >= begin
    return Walk(
        f"{walk.name} unrested",
        walk.t_s[begin:] - walk.t_s[begin],
        walk.acc_b_m_s2[begin:],
        walk.gyro_b_rad_s[begin:],
        Truth(truth.at[kept] - begin, truth.pos_t_m[kept], truth.from_start),
    )


def trials_of(walks: list[Walk]) -> list[Trial]:
    """All that is run; of each group every second walk is in the same half, as are copies."""
    counts, found = dict.fromkeys(LIMITS_M, 0), []
    for walk in sorted(walks, key=lambda each: each.name):
        if walk.truth is None:
            groups = ("loops",)
        elif walk.truth.from_start:
            groups = ("footprints",)
        else:
            groups = ("cameras", "stairs") if walk.name.startswith(STAIRS) else ("cameras",)
        half = counts[groups[-1]] % 2
        counts[groups[-1]] += 1
        found.append(Trial(walk, groups, half))
        if groups == ("footprints",):
            found.append(Trial(unrested(walk), ("unrested",), half))
    return found


def figure_m(errors: Errors, group: str) -> float:
    """The one that counts in this group."""
    if group == "loops":
        return errors.closure_m
    return errors.rmse_3d_m if group == "stairs" else errors.rmse_2d_m


def means_m(trials: list[Trial], errors: list[Errors]) -> dict[str, float]:
    """By group; those without a walk are left out."""
    found = {}
    for group in LIMITS_M:
        values = [
            figure_m(each, group)
            for trial, each in zip(trials, errors, strict=True)
            if group in trial.groups
        ]
        if values:
            found[group] = float(np.mean(values))
    return found


def cost(means: dict[str, float]) -> float:
    """What a search makes small."""
    return sum(mean / LIMITS_M[group] for group, mean in means.items())


def changed(setting: Setting, rng: np.random.Generator, count: int) -> Setting:
    """So many of its values drawn anew, near or less near, on two digits, within their ranges."""
    found, spread = dict(setting), SPREAD * 2 ** rng.uniform(-2, 1)
    for key in rng.choice(list(RANGES), count, replace=False):
        value = setting[key] * np.exp(spread * rng.standard_normal())
        found[str(key)] = float(f"{np.clip(value, *RANGES[key]):.2g}")
    return found


def run(trials: list[Trial], setting: Setting, *, causal: bool = False) -> list[Errors]:
    """Errors of each."""
    return [errors_m(trial.walk, setting, causal=causal) for trial in trials]


def chosen_from_few(trials: list[Trial], seed: int, advance: Callable[[], None]) -> list[Setting]:
    """Which candidate each half chooses."""
    rng = np.random.default_rng(seed)
    candidates = [START] + [changed(START, rng, len(RANGES) // 2) for _ in range(CANDIDATES - 1)]
    costs = []
    for candidate in candidates:
        errors = run(trials, candidate, causal=True)
        costs.append([cost(_of_half(trials, errors, half)) for half in (0, 1)])
        advance()
    return [candidates[at] for at in np.argmin(costs, axis=0)]


def _of_half(trials: list[Trial], errors: list[Errors], half: int) -> dict[str, float]:
    inside = [at for at, trial in enumerate(trials) if trial.half == half]
    return means_m([trials[at] for at in inside], [errors[at] for at in inside])


def searched(
    trials: list[Trial], steps: int, seed: int, advance: Callable[[], None]
) -> tuple[Setting, list[float]]:
    """The best setting for these trials of so many steps from START, and its cost as it fell."""
    rng, best = np.random.default_rng(seed), START
    costs = [cost(means_m(trials, run(trials, best, causal=True)))]
    for _ in range(steps):
        candidate = changed(best, rng, int(rng.integers(1, STEPS_OF + 1)))
        found = cost(means_m(trials, run(trials, candidate, causal=True)))
        if found < costs[-1]:
            best = candidate
        costs.append(min(found, costs[-1]))
        advance()
    return best, costs


def report(trials: list[Trial], steps: int | None, seed: int, advance: Callable[[], None]) -> dict:
    """All that is told."""
    now = shipped()
    found = {"limits_m": LIMITS_M, "seed": seed, "shipped": {"setting": now}}
    for mode in ("recorded", "causal"):
        means = means_m(trials, run(trials, now, causal=mode == "causal"))
        found["shipped"][mode] = {"cost": cost(means), "mean_m": means}
    if steps is None:
        settings = chosen_from_few(trials, seed, advance)
    else:
        halves = [[trial for trial in trials if trial.half == half] for half in (0, 1)]
        both = [searched(own, steps, seed + half, advance) for half, own in enumerate(halves)]
        settings, found["costs"] = map(list, zip(*both, strict=True))
    # Each half is judged by what the other one chose.
    judged = [errors_m(trial.walk, settings[1 - trial.half]) for trial in trials]
    means = means_m(trials, judged)
    found["left_out"] = {"cost": cost(means), "mean_m": means, "settings": settings}
    return found


def show(found: dict, console: Console) -> None:
    """A table for people."""
    table = Table(title="means in m, by group", title_justify="left")
    table.add_column("group")
    rows = {
        "shipped": found["shipped"]["recorded"],
        "shipped, causal": found["shipped"]["causal"],
        "chosen by the other half": found["left_out"],
    }
    for heading in ("limit", *rows):
        table.add_column(heading)
    for group in found["left_out"]["mean_m"]:
        cells = [f"{each['mean_m'][group]:.3f}" for each in rows.values()]
        table.add_row(group, f"{LIMITS_M[group]:.2f}", *cells)
    table.add_row("cost", "", *(f"{each['cost']:.3f}" for each in rows.values()))
    console.print(table)
    for half, setting in enumerate(found["left_out"]["settings"]):
        words = ", ".join(f"{key} {value:g}" for key, value in setting.items())
        console.print(f"half {half} chose: {words}")


def main() -> int:
    """Command line, see above."""
    parser = argparse.ArgumentParser(prog="tune.walks", description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="one JSON object, nothing else")
    parser.add_argument("--search", type=int, metavar="N", help="steps of each half's search")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("folder", nargs="*", type=Path)
    options = parser.parse_args()
    trials = trials_of(recorded_walks(options.folder, FOLDERS))
    if {trial.half for trial in trials} != {0, 1}:
        print("tune: for two halves, two walks of a kind are needed", file=sys.stderr)
        return 2
    total = CANDIDATES if options.search is None else 2 * options.search
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("settings", total=total)
        found = report(trials, options.search, options.seed, lambda: progress.advance(task))
    if options.json:
        print(json.dumps(found))
    else:
        show(found, Console(highlight=False))
    return 0


if __name__ == "__main__":
    sys.exit(main())
