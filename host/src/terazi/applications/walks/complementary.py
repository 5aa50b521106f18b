# SPDX-License-Identifier: MIT
"""Navigator (a), the article's: an explicit complementary filter (the chip's own, cshared.Mahony),
then integration of the acceleration that gravity does not explain, with zero velocity in stances.

What velocity a swing ends with is drift; it grew evenly, so a straight line is taken off. Causal:
each sample as this would have told it, had the record ended there. A recorded position leaves that
by no more than `held_m`: then it stays where it is when the end of the record is cut off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from terazi.applications.walks.clipping import AHEAD_S
from terazi.applications.walks.detectors import Detection
from terazi.applications.walks.navigator import (
    GRAVITY_M_S2,
    HELD_M,
    Path,
    final_samples,
    glided,
    held,
    revised_piece,
)
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
    held_m: float = HELD_M


def _counts(values: np.ndarray, per_unit: float) -> np.ndarray:
    return np.clip(np.rint(values * per_unit), -INT16, INT16).astype(np.int16)


def attitudes(
    walk: Walk, gyro_rad_s: np.ndarray, still: np.ndarray, settings: ComplementarySettings
) -> np.ndarray:
    """(n, 4) quat_wb by these (n, 3) rates, fixed point as on the chip."""
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
    """Run it; decisions are revised as for `kalman`."""
    still, at_once = detection.still, detection.at_once or detection
    quats = attitudes(walk, walk.rates.known_b_rad_s, still, settings)
    raw = _raw_velocity(walk, quats)
    vel = raw - _drift(raw, np.arange(len(walk)), np.flatnonzero(still))
    pos = _travelled(vel, walk.dt_s)
    final = final_samples(walk, max(detection.ahead_s, AHEAD_S))
    if causal or np.isfinite(detection.ahead_s):
        after = len(walk) - final
        told_quats = attitudes(walk, walk.rates.at_once_b_rad_s, still, settings)
        told_pos, told_vel = _at_once(walk, quats, told_quats, pos, still, at_once.still, after)
        told_pos = glided(told_pos, told_vel, walk.dt_s)
        if causal:
            return Path(told_pos, told_vel, told_quats, at_once.still, len(walk))
    stands = np.flatnonzero(still[:final])
    known = int(stands[-1]) + 1 if len(stands) else 0  # a swing is, when the stance after it is
    if np.isfinite(detection.ahead_s):
        pos[:known] = held(told_pos[:known], pos[:known], settings.held_m)
        pos[known:], vel[known:] = told_pos[known:], told_vel[known:]
    return Path(pos, vel, quats, still, known)


def _raw_velocity(walk: Walk, quats: np.ndarray) -> np.ndarray:
    """(n, 3) what is not gravity, integrated."""
    free = rotated(quats, walk.acc_b_m_s2) - [0.0, 0.0, GRAVITY_M_S2]
    return np.cumsum(free * walk.dt_s[:, None], axis=0)


def _drift(raw: np.ndarray, at: np.ndarray, stands: np.ndarray) -> np.ndarray:
    """(k, 3) of the raw velocity at samples `at`: all of it where it stands, a line in between."""
    if len(stands) == 0:
        return np.zeros((len(at), 3))
    return np.column_stack([np.interp(at, stands, column[stands]) for column in raw.T])


def _travelled(vel: np.ndarray, dt_s: np.ndarray) -> np.ndarray:
    """(n, 3) positions; before the first sample it stood."""
    before = np.vstack([np.zeros((1, 3)), vel[:-1]])
    return np.cumsum((vel + before) / 2 * dt_s[:, None], axis=0)


def _at_once(
    walk: Walk,
    quats: np.ndarray,
    told_quats: np.ndarray,
    pos: np.ndarray,
    still: np.ndarray,
    still_at_once: np.ndarray,
    after: int,
) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) positions and velocities as each sample is known at that sample.

    quats, pos, still : in the end; what is `after` samples old is known of them.

    From the last stance that is known to be one, positions are found anew at the begin of each
    piece, from what was decided since; within a piece a stance only sets the velocity to zero. The
    attitude of that stance is known better by then, too: all is turned by how much.
    """
    count, piece, dt_s = len(walk), revised_piece(walk), walk.dt_s
    raw, turns = _raw_velocity(walk, told_quats), _turns(quats, told_quats)
    told_pos, told_vel = np.empty((count, 3)), np.empty((count, 3))
    last = np.maximum.accumulate(np.where(still, np.arange(count), -1))
    for begin in range(0, count, piece):
        end, final = min(begin + piece, count), max(0, begin - after)
        stood = int(last[final - 1]) if final else -1
        base = max(stood, 0)
        since = final + np.flatnonzero(still_at_once[final:begin])
        seen = np.concatenate([[stood], since]).astype(np.int64) if stood >= 0 else since
        at = np.arange(base, end)
        drift = _drift(raw, at, seen)
        now = np.where(still_at_once[begin:end], np.arange(begin, end), -1)
        now = np.maximum.accumulate(now)
        drift[begin - base :][now >= 0] = raw[now[now >= 0]]
        along = raw[base:end] - drift
        vel = sum(along[:, axis, None] * turns[base, :, axis] for axis in range(3))
        way = _travelled(vel, np.concatenate([[0.0], dt_s[base + 1 : end]]))
        if stood >= 0:
            way += pos[stood]
        told_pos[begin:end], told_vel[begin:end] = way[begin - base :], vel[begin - base :]
    return told_pos, told_vel


def _turns(quats: np.ndarray, told_quats: np.ndarray) -> np.ndarray:
    """(n, 3, 3) from what was taken for the world by one attitude to what it is by the other."""
    back = told_quats * [1.0, -1.0, -1.0, -1.0]
    axes = (np.broadcast_to(axis, (len(quats), 3)) for axis in np.eye(3))
    return np.stack([rotated(quats, rotated(back, axis)) for axis in axes], axis=-1)
