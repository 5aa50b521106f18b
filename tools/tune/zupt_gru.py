# SPDX-License-Identifier: MIT
"""How often the chip's learnt detector decides as the network in floats does.

    ./dev run python -m tools.tune.zupt_gru [--json] [--seen] [FOLDER ...]

Recorded walks become whole counts of an MPU-6050 and run through the chip's code:

    agree    at the network's own 200 Hz, each sample given to the chip until the next one, against
             `terazi walk`'s network in floats, of which is asked what the chip asks: share of the
             walk's samples that are decided alike
    500hz    as the device samples: 500 Hz, by straight lines, against terazi.models.zupt_gru of the
             same counts: share of the steps, each decision where the chip tells it, a sample later

`path` is the 2-D error in m of the causal navigator of `terazi walk` where it knows nothing but
these decisions, the chip's and the network's.
--seen: nothing of that, but the table [seen] of zupt_gru.toml, for which rows of weights are
rounded: what the network sees where the simulator walks.
FOLDER: walks; without it, all below walks in TERAZI_DATA.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from terazi.applications.walks import networks, simulator
from terazi.applications.walks.record import Walk
from terazi.cshared import ZuptGru
from terazi.design import zupt as design
from terazi.design import zupt_gru
from terazi.models import zupt_gru as model
from tools.gen.zupt_gru_weights import floats, gate
from tools.tune.recorded import recorded_walks
from tools.tune.zupt import Trial, known

FOLDERS = ("vicon", "footprints", "xio_2011", "xio_gait")
NETWORK_HZ = 200.0
TIMES = 5  # samples of 1 ms a step
SAMPLE_MS = 2  # of tools.tune.zupt


def seen() -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance (terazi.design.zupt_gru) of a walk with stairs, running at last."""
    pieces = [
        *simulator.stand(2.0),
        *simulator.strides(12),
        *simulator.staircase(6),
        *simulator.strides(6, simulator.RUNNING),
    ]
    inputs = networks.features(simulator.simulate(pieces, seed=1), "magnitudes", NETWORK_HZ)
    return zupt_gru.moments(floats(), inputs.astype(float))


def seen_table() -> str:
    """The same as it stands in the spec: of the covariance the lower half."""
    mean, covariance = (np.round(each, 5) for each in seen())
    rows = [row[: n + 1] for n, row in enumerate(covariance)]
    return "\n".join(
        ["[seen]", f"mean = {mean.tolist()}", "covariance = [",
         *(f"    {row.tolist()}," for row in rows), "]"]
    )  # fmt: skip


def newest(walk: Walk) -> np.ndarray:
    """(m,) sample of each of the network's steps: the newest there is, as networks.features has."""
    steps = len(networks.features(walk, "magnitudes", NETWORK_HZ))
    if steps == len(walk.t_s):
        return np.arange(steps)
    times_s = walk.t_s[0] + np.arange(steps) / NETWORK_HZ
    return np.searchsorted(walk.t_s, times_s + 1e-9, side="right") - 1


def counts_of(walk: Walk, at: np.ndarray) -> list[np.ndarray]:
    """(m, 3) int16 of gyroscope and accelerometer at these samples."""
    sensor = design.spec()["sensor"]
    return [
        np.clip(np.rint(v[at] * design.counts_per_unit(name, sensor)), -32768, 32767).astype("i2")
        for v, name in ((walk.gyro_b_rad_s, "are"), (walk.acc_b_m_s2, "magnitude"))
    ]


def chip(walk: Walk) -> np.ndarray:
    """(n,) bool at the walk's samples: what the chip decides at the network's own rate."""
    gyro, acc = (np.repeat(each, TIMES, axis=0) for each in counts_of(walk, newest(walk)))
    return networks.at_walk_rate(ZuptGru(1).block(gyro, acc)[TIMES - 1 :: TIMES], walk, NETWORK_HZ)


def host(walk: Walk) -> np.ndarray:
    """(n,) bool at the walk's samples: what the network in floats decides."""
    inputs = networks.features(walk, "magnitudes", NETWORK_HZ)
    found = zupt_gru.scores(floats(), inputs.astype(float))
    return networks.at_walk_rate(found >= zupt_gru.asked(found, gate()), walk, NETWORK_HZ)


def agree_500hz(trial: Trial) -> float:
    """Share of the steps decided as the float64 model decides of the same counts."""
    gyro, acc = trial.counts
    sensor = design.spec()["sensor"]
    scales = (design.counts_per_unit(name, sensor) for name in ("are", "magnitude"))
    physical = [each / scale for each, scale in zip((gyro, acc), scales, strict=True)]
    at, scores, asked = model.zupt_gru(
        *physical, network=floats(), gate=gate(), sample_ms=SAMPLE_MS
    )
    flags = ZuptGru(SAMPLE_MS).block(gyro, acc)
    told = at + 1 < len(flags)
    return float(np.mean(flags[at[told] + 1] == (scores >= asked)[told]))


def report(walk: Walk) -> dict:
    """Figures of one walk."""
    trial, ours, theirs = Trial(walk), chip(walk), host(walk)
    return {
        "walk": walk.name,
        "samples": len(ours),
        "agree": float(np.mean(ours == theirs)),
        "agree_500hz": agree_500hz(trial),
        "still": {"chip": float(ours.mean()), "float": float(theirs.mean())},
        "path_m": {"chip": trial.path_m(ours), "float": trial.path_m(theirs)},
    }


def summary(rows: list[dict]) -> dict:
    """Over all walks; `samples` is the share of all samples, long walks counting more."""
    weights = [row["samples"] for row in rows]
    return {
        name: {
            "mean": float(np.mean([row[name] for row in rows])),
            "samples": float(np.average([row[name] for row in rows], weights=weights)),
            "worst": min(row[name] for row in rows),
            "worst_walk": min(rows, key=lambda row: row[name])["walk"],
        }
        for name in ("agree", "agree_500hz")
    } | {"path_m": {side: known(row["path_m"][side] for row in rows) for side in ("chip", "float")}}


def show(found: dict, console: Console) -> None:
    """A table for people."""
    table = Table(title="chip against the network in floats", title_justify="left")
    for heading in ("walk", "agree", "500hz", "still: chip, float", "path m: chip, float"):
        table.add_column(heading)
    for row in found["walks"]:
        path = ("-" if v is None else f"{v:.3f}" for v in row["path_m"].values())
        table.add_row(
            row["walk"],
            f"{row['agree']:.4f}",
            f"{row['agree_500hz']:.4f}",
            ", ".join(f"{v:.3f}" for v in row["still"].values()),
            ", ".join(path),
        )
    console.print(table)
    for name in ("agree", "agree_500hz"):
        each = found["all"][name]
        console.print(
            f"{name}: mean {each['mean']:.4f}, of all samples {each['samples']:.4f}, "
            f"worst {each['worst']:.4f} ({each['worst_walk']})"
        )
    console.print("path m: " + ", ".join(f"{k} {v:.3f}" for k, v in found["all"]["path_m"].items()
                                         if v is not None))  # fmt: skip


def main() -> int:
    """Command line, see above."""
    parser = argparse.ArgumentParser(prog="tune.zupt_gru", description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="one JSON object, nothing else")
    parser.add_argument("--seen", action="store_true", help="a table for zupt_gru.toml")
    parser.add_argument("folder", nargs="*", type=Path)
    options = parser.parse_args()
    if options.seen:
        print(seen_table())
        return 0
    rows = [report(walk) for walk in recorded_walks(options.folder, FOLDERS)]
    found = {"walks": rows, "all": summary(rows)}
    if options.json:
        print(json.dumps(found))
    else:
        show(found, Console(highlight=False, width=None))
    return 0


if __name__ == "__main__":
    sys.exit(main())
