# SPDX-License-Identifier: MIT
"""Errors of an attitude as BROAD defines them (Laidig et al. 2021, sec. 3.3).

With e = q_estimate (x) conj(q_truth), in the world frame, w x y z its parts:

    total        2 acos |w|                 the whole rotation that is wrong
    heading      2 atan |z / w|             its share about the vertical
    inclination  2 acos sqrt(w^2 + z^2)     its share about a level axis

A trial's figure is the root of the mean square over the samples that move and have a truth.
Six axes know no north: there, the one constant turn about the vertical that makes the mean square
of 2 sin(total / 2) least is taken off each trial first, so that heading and total say how the
heading drifts. The inclination is the same with and without.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass

import numpy as np

from terazi.applications.attitude.trials import Trial


@dataclass(frozen=True)
class Errors:
    """Root mean squares over one trial."""

    inclination_rmse_deg: float
    heading_rmse_deg: float
    total_rmse_deg: float


@dataclass(frozen=True)
class Score:
    """Errors of all trials by name."""

    trials: dict[str, Errors]

    def _over(self, reduce: Callable) -> Errors:
        rows = [list(asdict(errors).values()) for errors in self.trials.values()]
        return Errors(*(float(value) for value in reduce(np.array(rows), axis=0)))

    @property
    def mean(self) -> Errors:
        """Mean of the trials' figures."""
        return self._over(np.mean)

    @property
    def worst(self) -> Errors:
        """The largest of each figure; not always of the same trial."""
        return self._over(np.max)

    def plain(self) -> dict:
        """What `terazi attitude score --json` prints."""
        return {
            "trials": {name: asdict(errors) for name, errors in self.trials.items()},
            "mean": asdict(self.mean),
            "worst": asdict(self.worst),
        }


def error_quaternions(estimate_wb, truth_wb) -> np.ndarray:
    """(n, 4) estimate (x) conj(truth), in the world frame; scalar first, as both arguments."""
    a, b = np.asarray(estimate_wb, dtype=np.float64), np.asarray(truth_wb, dtype=np.float64)
    scalar = np.sum(a * b, axis=1)
    vector = b[:, :1] * a[:, 1:] - a[:, :1] * b[:, 1:] - np.cross(a[:, 1:], b[:, 1:])
    return np.column_stack([scalar, vector])


def without_heading_offset(errors: np.ndarray) -> np.ndarray:
    """The error quaternions after the constant turn about the vertical that fits best.

    The scalar of conj(turn) (x) e is w cos(h/2) + z sin(h/2); the sum of its squares is largest
    for h = angle of sum (w + i z)^2.
    """
    level = errors[:, 0] + 1j * errors[:, 3]
    half = np.angle(np.sum(level**2)) / 2
    turned = level * np.exp(-1j * half)
    side = (errors[:, 1] + 1j * errors[:, 2]) * np.exp(-1j * half)
    return np.column_stack([turned.real, side.real, side.imag, turned.imag])


def attitude_errors(estimate_wb, truth_wb, *, heading_is_free: bool) -> Errors:
    """Errors over (n, 4) unit quaternions, all of which count."""
    parts = error_quaternions(estimate_wb, truth_wb)
    if heading_is_free:
        parts = without_heading_offset(parts)
    w, z = np.abs(parts[:, 0]), np.abs(parts[:, 3])
    level = np.hypot(parts[:, 1], parts[:, 2])
    # atan2 of both parts where the formula has acos: acos loses half its digits near one.
    inclination = 2 * np.arctan2(level, np.hypot(w, z))
    heading = 2 * np.arctan2(z, w)
    total = 2 * np.arctan2(np.hypot(level, z), w)
    return Errors(
        *(float(np.degrees(np.sqrt(np.mean(e**2)))) for e in (inclination, heading, total))
    )


def score(
    trials: Iterable[Trial], estimate: Callable[[Trial], np.ndarray], *, heading_is_free: bool
) -> Score:
    """Errors of `estimate`, which gives (n, 4) unit quaternions of a trial, over all trials."""
    found = {}
    for trial in trials:
        counted = trial.scored
        found[trial.name] = attitude_errors(
            estimate(trial)[counted], trial.truth_wb[counted], heading_is_free=heading_is_free
        )
    return Score(found)
