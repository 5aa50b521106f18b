# SPDX-License-Identifier: MIT
"""The attitude filter beside vqf, imufusion and ahrs: throughput, and errors on BROAD's trials.

Peers run at their published defaults, each told the true rate. vqf takes whole arrays; imufusion
has nothing but one sample a call; ahrs loops in Python, so that it stands in the six axes' table
only, where it takes a minute. Errors are those of terazi.applications.attitude.score.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path

import ahrs
import imufusion
import numpy as np
import vqf
from filters import compared

from terazi.applications.attitude.chain import estimate
from terazi.applications.attitude.score import Errors, Score, attitude_errors
from terazi.applications.attitude.trials import (
    ACC_COUNTS_PER_G,
    GYRO_COUNTS_PER_DEG_S,
    MAG_COUNTS_PER_UT,
    RATE_HZ,
    Trial,
    find_trials,
    load_trial,
)

STANDARD_GRAVITY_M_S2 = 9.80665
SAMPLES = 1 << 17
SEED = 21


def physical(trial: Trial) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """rad/s, m/s^2, uT."""
    gyro = np.radians(trial.gyro_b_counts / GYRO_COUNTS_PER_DEG_S)
    acc = trial.acc_b_counts * (STANDARD_GRAVITY_M_S2 / ACC_COUNTS_PER_G)
    return gyro, acc, trial.mag_b_counts / MAG_COUNTS_PER_UT


def vqf_6(trial: Trial) -> np.ndarray:
    gyro, acc, _ = physical(trial)
    return vqf.VQF(1 / trial.rate_hz).updateBatch(gyro, acc)["quat6D"]


def vqf_9(trial: Trial) -> np.ndarray:
    return vqf.VQF(1 / trial.rate_hz).updateBatch(*physical(trial))["quat9D"]


def _imufusion(trial: Trial, update: Callable) -> np.ndarray:
    filter_, settings = imufusion.Ahrs(), imufusion.AhrsSettings()
    settings.convention, settings.sample_rate = imufusion.CONVENTION_ENU, trial.rate_hz
    filter_.set_settings(settings)
    quats = np.empty((len(trial.moving), 4))
    gyro, acc, mag = physical(trial)
    gyro_deg_s, acc_g = np.degrees(gyro), acc / STANDARD_GRAVITY_M_S2
    for n in range(len(quats)):
        update(filter_, gyro_deg_s[n], acc_g[n], mag[n])
        quats[n] = filter_.get_quaternion()
    return quats


def imufusion_6(trial: Trial) -> np.ndarray:
    return _imufusion(
        trial, lambda filter_, gyro, acc, _: filter_.update_no_magnetometer(gyro, acc)
    )


def imufusion_9(trial: Trial) -> np.ndarray:
    return _imufusion(trial, imufusion.Ahrs.update)


def ahrs_madgwick_6(trial: Trial) -> np.ndarray:
    gyro, acc, _ = physical(trial)
    return ahrs.filters.Madgwick(gyr=gyro, acc=acc, frequency=trial.rate_hz).Q


def ahrs_mahony_6(trial: Trial) -> np.ndarray:
    gyro, acc, _ = physical(trial)
    return ahrs.filters.Mahony(gyr=gyro, acc=acc, frequency=trial.rate_hz).Q


def ours_6(trial: Trial) -> np.ndarray:
    return estimate(trial, mode=6)


def ours_6_linear(trial: Trial) -> np.ndarray:
    return estimate(trial, mode=6, filter="linear")


def ours_6_classic(trial: Trial) -> np.ndarray:
    return estimate(trial, mode=6, filter="classic")


def ours_9(trial: Trial) -> np.ndarray:
    return estimate(trial, mode=9)


METHODS: dict[int, dict[str, Callable[[Trial], np.ndarray]]] = {
    6: {
        "terazi": ours_6,
        "terazi, linear": ours_6_linear,
        "terazi, classic": ours_6_classic,
        "vqf.VQF": vqf_6,
        "imufusion.Ahrs": imufusion_6,
        "ahrs.Madgwick": ahrs_madgwick_6,
        "ahrs.Mahony": ahrs_mahony_6,
    },
    9: {"terazi": ours_9, "vqf.VQF": vqf_9, "imufusion.Ahrs": imufusion_9},
}


def trial_errors(path: Path) -> dict[int, dict[str, Errors]]:
    """All methods on one trial."""
    trial = load_trial(path)
    counted = trial.scored
    return {
        axes: {
            name: attitude_errors(
                method(trial)[counted], trial.truth_wb[counted], heading_is_free=axes == 6
            )
            for name, method in methods.items()
        }
        for axes, methods in METHODS.items()
    }


def accuracy(folder: str | None = None) -> dict:
    """Mean and worst of each method, or why there is none."""
    data = folder or os.environ.get("TERAZI_DATA")
    if not data:
        return {"skipped": "TERAZI_DATA is unset: no BROAD trials to score"}
    broad = Path(data) / "attitude" / "broad"
    if not broad.is_dir():
        return {"skipped": f"no folder attitude/broad in TERAZI_DATA ({data})"}
    paths = find_trials(broad)
    print(f"bench: {len(paths)} BROAD trials through 10 filters, a minute ...", file=sys.stderr)
    with ProcessPoolExecutor() as pool:
        found = list(pool.map(trial_errors, paths))
    return {"trials": len(paths), **dict(_tables(paths, found))}


def _tables(paths: list[Path], found: list) -> Iterator[tuple[str, dict]]:
    for axes, methods in METHODS.items():
        table = {}
        for name in methods:
            score = Score(
                {path.stem: one[axes][name] for path, one in zip(paths, found, strict=True)}
            )
            table[name] = {"mean": asdict(score.mean), "worst": asdict(score.worst)}
        yield f"axes_{axes}", table


def swinging() -> Trial:
    """A board in the hand: counts for throughput, where the truth does not matter."""
    rng = np.random.default_rng(SEED)
    t = np.arange(SAMPLES) / RATE_HZ
    gyro = 2000 * np.sin(np.outer(t, (1.1, 2.3, 0.7))) + rng.normal(0, 2, (SAMPLES, 3))
    acc = (0, 0, 2048) + 500 * np.sin(np.outer(t, (2.0, 1.3, 3.1)))
    mag = np.tile([0.0, 1900.0, -4600.0], (SAMPLES, 1))
    counts = (np.rint(each).astype(np.int16) for each in (gyro, acc, mag))
    truth = np.tile([1.0, 0, 0, 0], (SAMPLES, 1))
    return Trial("swinging", RATE_HZ, *counts, truth, np.ones(SAMPLES, dtype=bool))


def throughput() -> dict[str, dict]:
    """mahony_block with imu_cal and rest before it, beside the peers in the same run."""
    trial = swinging()
    gyro, acc, mag = physical(trial)
    return {
        "mahony_block_6_beside_vqf": compared(
            SAMPLES,
            lambda: ours_6(trial),
            "vqf.VQF.updateBatch",
            lambda: vqf.VQF(1 / RATE_HZ).updateBatch(gyro, acc),
        ),
        "mahony_block_9_beside_vqf": compared(
            SAMPLES,
            lambda: ours_9(trial),
            "vqf.VQF.updateBatch",
            lambda: vqf.VQF(1 / RATE_HZ).updateBatch(gyro, acc, mag),
        ),
        "mahony_block_6_beside_imufusion": compared(
            SAMPLES,
            lambda: ours_6(trial),
            "imufusion.Ahrs, a sample a call",
            lambda: imufusion_6(trial),
        ),
    }
