# SPDX-License-Identifier: MIT
"""Navigator (a), the article's: an explicit complementary filter (the chip's own, cshared.Mahony),
then integration of the acceleration that gravity does not explain, with zero velocity in stances.

What velocity a swing ends with is drift; it grew evenly, so a straight line is taken off. Causal:
the velocity is only set to zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from terazi.applications.walks.detectors import Detection
from terazi.applications.walks.navigator import GRAVITY_M_S2, Path, final_samples
from terazi.applications.walks.record import Walk
from terazi.cshared import Mahony, Rest
from terazi.design import mahony as mahony_design
from terazi.design import rest as rest_design

GYRO_COUNTS_PER_RAD_S = 16.384 * 180 / np.pi
ACC_COUNTS_PER_M_S2 = 2048 / 9.80665
INT16 = 32767


@dataclass(frozen=True)
class ComplementarySettings:
    """bias: how the gyroscope's is removed.

    "rest": learnt at rest, as the device does. "start": the mean of the first standstill, as the
    article does. "none".
    """

    mode: str = "second_order"
    bias: str = "rest"
    start_still_s: float = 0.5


def _counts(values: np.ndarray, per_unit: float) -> np.ndarray:
    return np.clip(np.rint(values * per_unit), -INT16, INT16).astype(np.int16)


def attitudes(walk: Walk, still: np.ndarray, settings: ComplementarySettings) -> np.ndarray:
    """(n, 4) quat_wb, fixed point as on the chip."""
    gyro_rad_s = walk.gyro_b_rad_s
    if settings.bias == "start":
        gyro_rad_s = gyro_rad_s - start_bias(walk, still, settings.start_still_s)
    gyro = _counts(gyro_rad_s, GYRO_COUNTS_PER_RAD_S)
    acc = _counts(walk.acc_b_m_s2, ACC_COUNTS_PER_M_S2)
    rest = None
    if settings.bias == "rest":
        rest = Rest(rest_design.config_at(walk.rate_hz))
    mahony = Mahony(mahony_design.config_at(walk.rate_hz, settings.mode))
    quats = mahony.block(gyro, acc, rest=rest).astype(np.float64)
    return quats / np.linalg.norm(quats, axis=1, keepdims=True)


def start_bias(walk: Walk, still: np.ndarray, least_s: float) -> np.ndarray:
    """(3,) mean rate of the stance with which the record begins; zero where that is short."""
    begin = int(np.argmax(still))
    moves = np.flatnonzero(~still[begin:])
    end = begin + (int(moves[0]) if len(moves) else len(still) - begin)
    if end - begin < least_s * walk.rate_hz:
        return np.zeros(3)
    return walk.gyro_b_rad_s[begin:end].mean(axis=0)


def rotated(quat_wb: np.ndarray, vectors_b: np.ndarray) -> np.ndarray:
    """(n, 3) body vectors in the world."""
    scalar, axis = quat_wb[:, :1], quat_wb[:, 1:]
    across = 2 * np.cross(axis, vectors_b)
    return vectors_b + scalar * across + np.cross(axis, across)


def complementary(
    walk: Walk, detection: Detection, settings: ComplementarySettings, *, causal: bool = False
) -> Path:
    """Run it."""
    still = detection.still
    quats = attitudes(walk, still, settings)
    dt_s = walk.dt_s[:, None]
    free = rotated(quats, walk.acc_b_m_s2) - [0.0, 0.0, GRAVITY_M_S2]
    vel = np.cumsum(free * dt_s, axis=0)
    at = np.arange(len(walk))
    if causal:
        last = np.maximum.accumulate(np.where(still, at, -1))
        vel = vel - np.where((last >= 0)[:, None], vel[last], 0.0)
    elif still.any():
        drift = np.column_stack([np.interp(at, at[still], column[still]) for column in vel.T])
        vel = vel - drift
    before = np.vstack([np.zeros((1, 3)), vel[:-1]])
    pos = np.cumsum((vel + before) / 2 * dt_s, axis=0)
    known = len(walk)
    if not causal:  # a swing is known when the stance after it is
        stands = np.flatnonzero(still[: final_samples(walk, detection.ahead_s)])
        known = int(stands[-1]) + 1 if len(stands) else 0
    return Path(pos, vel, quats, still, known)
