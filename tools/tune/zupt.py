# SPDX-License-Identifier: MIT
"""How well the chip's detectors of zero velocity agree with the host's, and which settings do best.

    ./dev run python -m tools.tune.zupt [--json] [--search] [FOLDER ...]

Recorded walks become what an MPU-6050 gives at 500 Hz (by straight lines between samples, in whole
counts) and run through the chip's code. A decision is compared with that of the float64 detector of
the same name of `terazi walk`, whose window is centred; hence the shift by which the chip is late
is taken out, one for all walks, and told. Where a trial has labels (found trial by trial with sight
of optical truth), both are compared with these too. `path` is the mean 2-D error in m of the causal
navigator of `terazi walk` where it knows nothing but these decisions.

--search: all settings of a grid, and what is chosen for a walk by the others (as tune.attitude).
FOLDER: walks; without it, walks/vicon and walks/footprints below TERAZI_DATA.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from terazi.applications.walks.detectors import Detection
from terazi.applications.walks.estimate import DETECTORS
from terazi.applications.walks.navigator import CAUSAL, kalman
from terazi.applications.walks.record import Walk
from terazi.applications.walks.score import path_errors
from terazi.cshared import Rest, Zupt
from terazi.design import zupt as design
from tools.tune.attitude import leave_one_out
from tools.tune.recorded import recorded_walks

FOLDERS = ("vicon", "footprints")
RATE_HZ = 500.0
HOST_NAMES = {name: name for name in design.detectors()} | {"are": "rate_energy"}
SHIFTS = range(0, 61, 5)  # samples by which the chip may be late
LEAST_S = 0.1  # a shorter stance is not asked for
GRID = {
    "share": (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2),  # of the host's limit, to enter
    "more": (1.0, 1.2, 1.4),  # to leave
    "still_blocks": (1, 2, 3),
    "stride": (1, 2),
}


@dataclass(frozen=True)
class Trial:
    """A walk and what the chip would have been given."""

    walk: Walk

    @cached_property
    def t_s(self) -> np.ndarray:
        """(n,) at 500 Hz."""
        return np.arange(self.walk.t_s[0], self.walk.t_s[-1], 1 / RATE_HZ)

    @cached_property
    def counts(self) -> tuple[np.ndarray, np.ndarray]:
        """(n, 3) int16 of gyroscope and accelerometer."""
        sensor = design.spec()["sensor"]
        values = self.walk.gyro_b_rad_s, self.walk.acc_b_m_s2
        scales = (design.counts_per_unit(name, sensor) for name in ("are", "magnitude"))
        return tuple(
            np.clip(
                np.rint(
                    np.column_stack([np.interp(self.t_s, self.walk.t_s, x) for x in v.T]) * scale
                ),
                -32768,
                32767,
            ).astype(np.int16)
            for v, scale in zip(values, scales, strict=True)
        )

    def chip(self, config: dict) -> np.ndarray:
        """(n,) bool, what zupt says."""
        return Zupt(config).block(*self.counts)

    def rests(self) -> np.ndarray:
        """(n,) bool, what rest says."""
        gyro, acc = self.counts
        _, flags = Rest("500hz").block(gyro, acc)
        return (flags & 1).astype(bool)

    def host(self, name: str) -> np.ndarray:
        """(n,) bool, what the host's detector says, of the nearest sample."""
        run, settings, _ = DETECTORS[HOST_NAMES[name]]
        return self.at_500hz(run(self.walk, settings, causal=False).still)

    def at_500hz(self, flags: np.ndarray) -> np.ndarray:
        """Flags of the walk's samples, each where it is the nearest."""
        return np.interp(self.t_s, self.walk.t_s, flags.astype(float)) > 0.5

    def at_walk(self, flags: np.ndarray) -> np.ndarray:
        """Flags at 500 Hz where the walk has samples: the newest that is known."""
        at = np.searchsorted(self.t_s, self.walk.t_s + 1e-9, side="right") - 1
        return flags[np.clip(at, 0, len(flags) - 1)]

    def path_m(self, flags: np.ndarray) -> float | None:
        """2-D error of the causal path from decisions alone, given for the walk's samples."""
        motion, threshold = np.where(flags, 0.5, 2.0), np.ones(len(flags))
        path = kalman(self.walk, Detection(motion, threshold, ""), CAUSAL, causal=True)
        return path_errors(self.walk, path.pos_w_m).rmse_2d_m


def differ(chip: np.ndarray, other: np.ndarray, shift: int) -> float:
    """Share of samples that decide otherwise, the chip being `shift` samples late."""
    return float(np.mean(chip[shift:] != other[: len(other) - shift]))


def runs(flags: np.ndarray) -> np.ndarray:
    """(k, 2) begin and end of each stretch that is true."""
    steps = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    return np.column_stack([np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)])


def delays(chip: np.ndarray, host: np.ndarray) -> tuple[list[float], list[float], int]:
    """ms by which stillness begins and ends later than the host's, stance by stance; those that
    the chip missed."""
    ours, begins, ends, missed = runs(chip), [], [], 0
    for begin, end in runs(host):
        if end - begin < LEAST_S * RATE_HZ:
            continue
        meets = ours[(ours[:, 0] < end) & (ours[:, 1] > begin)]
        if len(meets) == 0:
            missed += 1
            continue
        begins.append((meets[0, 0] - begin) * 1000 / RATE_HZ)
        ends.append((meets[-1, 1] - end) * 1000 / RATE_HZ)
    return begins, ends, missed


def known(values) -> float | None:
    """Mean of those that are known."""
    values = [value for value in values if value is not None]
    return float(np.mean(values)) if values else None


def agreement(name: str, trials: list[Trial]) -> dict:
    """Of one detector with its shipped settings."""
    chips = [trial.chip(design.config_at(name, RATE_HZ)) for trial in trials]
    hosts = [trial.host(name) for trial in trials]
    apart = np.array([[differ(c, h, s) for c, h in zip(chips, hosts, strict=True)] for s in SHIFTS])
    best = int(apart.mean(axis=1).argmin())
    found = [delays(c, h) for c, h in zip(chips, hosts, strict=True)]
    begins, ends = (np.concatenate([each[side] for each in found]) for side in (0, 1))
    labelled = [
        (trial, chip, host)
        for trial, chip, host in zip(trials, chips, hosts, strict=True)
        if trial.walk.zero_velocity is not None
    ]
    labels = {
        "chip": [
            1 - differ(chip, trial.at_500hz(trial.walk.zero_velocity), SHIFTS[best])
            for trial, chip, _ in labelled
        ],
        "host": [
            1 - differ(host, trial.at_500hz(trial.walk.zero_velocity), 0)
            for trial, _, host in labelled
        ],
    }
    run, _, causal = DETECTORS[HOST_NAMES[name]]
    return {
        "agree": 1 - float(apart[best].mean()),
        "agree_worst": 1 - float(apart[best].max()),
        "agree_without_shift": 1 - float(apart[0].mean()),
        "shift_ms": SHIFTS[best] * 1000 / RATE_HZ,
        "begins_late_ms": float(np.median(begins)),
        "ends_late_ms": float(np.median(ends)),
        "ends_late_95_ms": float(np.percentile(ends, 95)),
        "stances": len(begins) + sum(each[2] for each in found),
        "missed": sum(each[2] for each in found),
        "labels": {side: known(values) for side, values in labels.items()},
        "path_m": {
            "chip": known(t.path_m(t.at_walk(c)) for t, c in zip(trials, chips, strict=True)),
            "host": known(t.path_m(run(t.walk, causal, causal=True).still) for t in trials),
        },
        "rest_says_still": float(np.mean([t.rests().mean() for t in trials])),
        "host_says_still": float(np.mean([h.mean() for h in hosts])),
        "chip_says_still": float(np.mean([c.mean() for c in chips])),
    }


def config_of(name: str, setting: dict) -> dict:
    """A point of the grid."""
    unit = "rad_s" if design.turns(name) else "m_s2"
    limit = DETECTORS[HOST_NAMES[name]][1].threshold * setting["share"]
    changed = {f"enter_{unit}": limit, f"leave_{unit}": limit * setting["more"]}
    fields = design.config_at(name, RATE_HZ, still_blocks=setting["still_blocks"], **changed)
    return {**fields, "stride": setting["stride"]}


def search(name: str, trials: list[Trial]) -> dict:
    """The grid, and what each walk would be given by the others."""
    settings = [dict(zip(GRID, point, strict=True)) for point in itertools.product(*GRID.values())]
    hosts = [trial.host(name) for trial in trials]
    apart = []
    for setting in settings:
        chips = [trial.chip(config_of(name, setting)) for trial in trials]
        by_shift = np.array(
            [[differ(c, h, s) for c, h in zip(chips, hosts, strict=True)] for s in SHIFTS]
        )
        apart.append(by_shift[by_shift.mean(axis=1).argmin()])
    apart = np.array(apart)
    chosen, left_out = leave_one_out(apart)
    return {
        "best": {
            "setting": settings[int(apart.mean(axis=1).argmin())],
            "agree": 1 - float(apart.mean(axis=1).min()),
        },
        "agree_by_stride": {
            stride: 1
            - min(
                float(mean)
                for mean, each in zip(apart.mean(axis=1), settings, strict=True)
                if each["stride"] == stride
            )
            for stride in GRID["stride"]
        },
        "left_out": {
            "agree": 1 - float(left_out.mean()),
            "settings": len(set(chosen.tolist())),
        },
    }


def show(reports: dict, console: Console) -> None:
    """Tables for people."""
    table = Table(title="chip against host, same detector", title_justify="left")
    for heading in ("detector", "agree", "worst walk", "late ms", "begins, ends late ms",
                    "missed", "labels: chip, host", "path m: chip, host"):  # fmt: skip
        table.add_column(heading)

    def pair(values: dict, form: str) -> str:
        return ", ".join("-" if v is None else format(v, form) for v in values.values())

    for name, row in reports.items():
        table.add_row(
            name,
            f"{row['agree']:.4f}",
            f"{row['agree_worst']:.4f}",
            f"{row['shift_ms']:.0f}",
            f"{row['begins_late_ms']:.0f}, {row['ends_late_ms']:.0f}",
            f"{row['missed']} of {row['stances']}",
            pair(row["labels"], ".4f"),
            pair(row["path_m"], ".3f"),
        )
    console.print(table)
    for name, row in reports.items():
        shares = ", ".join(
            f"{who} {row[f'{who}_says_still']:.3f}" for who in ("chip", "host", "rest")
        )
        console.print(f"{name}: share of time still: {shares}")
        if "search" in row:
            console.print(f"    best of the grid {row['search']['best']}")
            console.print(f"    best by stride {row['search']['agree_by_stride']}")
            console.print(f"    left out {row['search']['left_out']}")


def main() -> int:
    """Command line, see above."""
    parser = argparse.ArgumentParser(prog="tune.zupt", description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="one JSON object, nothing else")
    parser.add_argument("--search", action="store_true", help="the whole grid too; minutes")
    parser.add_argument("folder", nargs="*", type=Path)
    options = parser.parse_args()
    trials = [Trial(walk) for walk in recorded_walks(options.folder, FOLDERS)]
    if len(trials) < 2 and options.search:
        print("tune: to leave one out, two walks are needed", file=sys.stderr)
        return 2
    reports = {}
    for name in design.detectors():
        reports[name] = agreement(name, trials)
        if options.search:
            reports[name]["search"] = search(name, trials)
    if options.json:
        print(json.dumps(reports))
    else:
        show(reports, Console(highlight=False, width=None))
    return 0


if __name__ == "__main__":
    sys.exit(main())
