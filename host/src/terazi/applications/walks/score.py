# SPDX-License-Identifier: MIT
"""Errors of a path against what is known of it.

Heading is not observable, so the path is turned about the vertical as fits best: about the mean of
all points (which are brought together first) or, where the truth is footprints from a start, about
the start. Errors are Euclidean: the root of the mean of dx^2 + dy^2 (+ dz^2), not of each axis.
Closure is the distance between first and last position, in three dimensions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass

import numpy as np

from terazi.applications.walks.record import Truth, Walk


@dataclass(frozen=True)
class Errors:
    """Of one walk; None where nothing is known."""

    rmse_2d_m: float | None
    rmse_3d_m: float | None
    closure_m: float | None


@dataclass(frozen=True)
class Score:
    """Errors by name."""

    trials: dict[str, Errors]

    @property
    def mean(self) -> Errors:
        """Over those trials where each is known."""
        means = []
        for name in Errors.__dataclass_fields__:
            known = [getattr(each, name) for each in self.trials.values()]
            known = [value for value in known if value is not None]
            means.append(float(np.mean(known)) if known else None)
        return Errors(*means)

    def plain(self) -> dict:
        """What `terazi walk score --json` prints."""
        return {
            "trials": {name: asdict(errors) for name, errors in self.trials.items()},
            "mean": asdict(self.mean),
        }


def aligned(pos_w_m: np.ndarray, truth: Truth) -> tuple[np.ndarray, np.ndarray]:
    """(k, d) the path at the truth's points, turned and shifted to it; (k, d) the truth."""
    wide = truth.pos_t_m.shape[1]
    ours, theirs = pos_w_m[truth.at][:, :wide], truth.pos_t_m
    centre_ours = ours[0] if truth.from_start else ours.mean(axis=0)
    centre_theirs = theirs[0] if truth.from_start else theirs.mean(axis=0)
    ours, theirs = ours - centre_ours, theirs - centre_theirs
    level = ours[:, 0] + 1j * ours[:, 1]
    turn = np.angle(np.sum((theirs[:, 0] + 1j * theirs[:, 1]) * level.conj()))
    turned = level * np.exp(1j * turn)
    ours = np.column_stack([turned.real, turned.imag, ours[:, 2:]])
    return ours + centre_theirs, truth.pos_t_m


def path_errors(walk: Walk, pos_w_m: np.ndarray) -> Errors:
    """Errors of (n, 3) positions, one a sample of the walk."""
    closure = float(np.linalg.norm(pos_w_m[-1] - pos_w_m[0])) if walk.may_return else None
    if walk.truth is None:
        return Errors(None, None, closure)
    ours, theirs = aligned(pos_w_m, walk.truth)
    square = (ours - theirs) ** 2
    rmse_2d = float(np.sqrt(square[:, :2].sum(axis=1).mean()))
    rmse_3d = float(np.sqrt(square.sum(axis=1).mean())) if square.shape[1] == 3 else None
    return Errors(rmse_2d, rmse_3d, closure)


def score(walks: Iterable[Walk], positions: Callable[[Walk], np.ndarray]) -> Score:
    """Errors of what `positions` makes of each walk, (n, 3) m."""
    return Score({walk.name: path_errors(walk, positions(walk)) for walk in walks})
