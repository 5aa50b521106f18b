# SPDX-License-Identifier: MIT
"""The gyroscope's bias from standstills, and its matrix from the turns between them.

Tedaldi, Pretto, Menegatti 2014, sec. 3: between two standstills the rates, integrated, must turn
the first direction of gravity into the second, both as the calibrated accelerometer feels them.
So the gyroscope's axes become the accelerometer's. Of each turn the part about the vertical does
not show; turns about all axes together show everything.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from terazi.applications.attitude.calibrated import SQUARE
from terazi.calibration.imu.least_squares import solve
from terazi.calibration.imu.quantise import Constants
from terazi.units import GYRO_COUNTS_PER_DEG_S

PRIOR_SCALE, PRIOR_CROSS = 0.03, 0.02  # +-3 %, +-2 %: PS-MPU-6000A-00 rev 3.4, p. 12
SIGMA_RAD = 0.002  # of a turn: bias that wanders, rates between samples
TURNED_LEAST_DEG = 30.0  # gravity's way between two standstills that says something
LONGEST_S = 20.0
TURNS_LEAST = 5
KNOWN_SD = 0.005  # a matrix whose worst element is known so well is used
RAIL = 32767


@dataclass(frozen=True)
class Turn:
    """What lies between two standstills."""

    rates_counts: np.ndarray  # (n, 3) raw, the standstills' ends among them
    bias_counts: np.ndarray  # (n, 3) at the same moments
    period_s: float
    up_before: np.ndarray  # (3,) unit vectors, calibrated
    up_after: np.ndarray

    @property
    def angle_deg(self) -> float:
        """By how much gravity turned."""
        cosine = np.clip(self.up_before @ self.up_after, -1.0, 1.0)
        return float(np.degrees(np.arccos(cosine)))


@dataclass(frozen=True)
class GyroscopeFit:
    """constants.matrix is the identity where the turns do not tell it."""

    constants: Constants
    is_matrix_known: bool
    matrix_sd: float  # of the worst element
    turns: int
    why_not: str = ""


def is_of_use(turn: Turn) -> bool:
    """Long enough a way, short enough a time, and never at a rail."""
    rates = turn.rates_counts.astype(np.int32)
    return (
        turn.angle_deg >= TURNED_LEAST_DEG
        and len(rates) * turn.period_s <= LONGEST_S
        and int(np.abs(rates).max()) < RAIL
    )


def fit_gyroscope(turns: Sequence[Turn], bias_counts: np.ndarray) -> GyroscopeFit:
    """bias_counts : (3,) raw, what the device is to take off."""
    turns = [turn for turn in turns if is_of_use(turn)]
    if len(turns) < TURNS_LEAST:
        why = f"only {len(turns)} turns are of use, {TURNS_LEAST} are wanted"
        return GyroscopeFit(Constants(np.eye(3), bias_counts), False, np.inf, len(turns), why)

    def matrix(x: np.ndarray) -> np.ndarray:
        found = np.eye(3)
        for place, value in zip(SQUARE, x, strict=True):
            found[place] += value
        return found

    def away(x: np.ndarray) -> np.ndarray:
        return np.concatenate([turned_wrong(turn, matrix(x)) for turn in turns]) / SIGMA_RAD

    prior = [PRIOR_SCALE if row == column else PRIOR_CROSS for row, column in SQUARE]
    solution = solve(away, np.zeros(9), np.array(prior))
    sd = float(solution.sd.max())
    if sd > KNOWN_SD:
        why = f"the turns leave {sd:.1%} open: turn it about each of its axes"
        return GyroscopeFit(Constants(np.eye(3), bias_counts), False, sd, len(turns), why)
    constants = Constants(matrix(solution.x), bias_counts)
    return GyroscopeFit(constants, True, sd, len(turns))


def turned_wrong(turn: Turn, matrix: np.ndarray) -> np.ndarray:
    """(3,) where gravity is after the turn less where the rates say that it is."""
    rates_deg_s = (turn.rates_counts - turn.bias_counts) @ matrix.T / GYRO_COUNTS_PER_DEG_S
    return turn.up_after - carried(turn.up_before, np.radians(rates_deg_s), turn.period_s)


def carried(up: np.ndarray, rate_b_rad_s: np.ndarray, period_s: float) -> np.ndarray:
    """A direction that stands still in the world, in the axes of a body after it turned so.

    rate_b_rad_s : (n, 3) at the ends of n - 1 periods, linear between them: the rotation vector of
    each period is then (w0 + w1) dt / 2 + (w0 x w1) dt^2 / 12.
    """
    first, second = rate_b_rad_s[:-1], rate_b_rad_s[1:]
    vectors = (first + second) * (period_s / 2) + np.cross(first, second) * (period_s**2 / 12)
    quats = _from_rotation(vectors)
    while len(quats) > 1:  # pair by pair: the order stays, and numpy does the work
        if len(quats) % 2:
            quats = np.vstack([quats, [[1.0, 0.0, 0.0, 0.0]]])
        quats = _product(quats[::2], quats[1::2])
    w, v = quats[0, 0], -quats[0, 1:]  # world to body
    across = np.cross(v, up)
    return up + 2 * (w * across + np.cross(v, across))


def _from_rotation(vectors: np.ndarray) -> np.ndarray:
    half = np.linalg.norm(vectors, axis=1) / 2
    return np.column_stack([np.cos(half), vectors * (np.sinc(half / np.pi) / 2)[:, None]])


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    scalar = a[:, 0] * b[:, 0] - np.sum(a[:, 1:] * b[:, 1:], axis=1)
    vector = a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + np.cross(a[:, 1:], b[:, 1:])
    return np.column_stack([scalar, vector])
