# SPDX-License-Identifier: MIT
"""Non-linear least squares with what is known beforehand: Levenberg and Marquardt's way.

A dozen unknowns: numpy is enough, and what runs on a user's machine needs no SciPy.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

ROUNDS = 60
STEP = 1e-6
SMALL = 1e-10  # a round that betters the sum by less than this share is the last


@dataclass(frozen=True)
class Solution:
    """Unknowns at the least sum, and how well data and foreknowledge determine them."""

    x: np.ndarray
    sd: np.ndarray  # one sigma of each
    residuals: np.ndarray  # of the data alone, as the caller scales them


def solve(
    residuals: Callable[[np.ndarray], np.ndarray], start: np.ndarray, prior_sd: np.ndarray
) -> Solution:
    """The x of least |residuals(x)|^2 + |x / prior_sd|^2.

    residuals : in sigmas of the data, so that both sums go together.
    prior_sd : of each unknown around zero; inf: nothing is known.
    """
    x = np.array(start, dtype=np.float64)
    known = 1.0 / np.asarray(prior_sd, dtype=np.float64)

    def all_of(at: np.ndarray) -> np.ndarray:
        return np.concatenate([residuals(at), at * known])

    now, damping = all_of(x), 1e-3
    for _round in range(ROUNDS):
        slopes = _jacobian(all_of, x, now)
        normal, downhill = slopes.T @ slopes, slopes.T @ now
        better = False
        while damping < 1e12:
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), -downhill)
            then = all_of(x + step)
            if then @ then < now @ now:
                better, damping = True, damping / 10
                break
            damping *= 10
        if not better:
            break
        gain = 1 - (then @ then) / (now @ now)
        x, now = x + step, then
        if gain < SMALL:
            break
    slopes = _jacobian(all_of, x, now)
    covariance = np.linalg.pinv(slopes.T @ slopes)
    return Solution(x, np.sqrt(np.diag(covariance)), residuals(x))


def _jacobian(function: Callable, x: np.ndarray, at_x: np.ndarray) -> np.ndarray:
    columns = np.empty((len(at_x), len(x)))
    for at in range(len(x)):
        beside = x.copy()
        beside[at] += STEP
        columns[:, at] = (function(beside) - at_x) / STEP
    return columns
