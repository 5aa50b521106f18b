# SPDX-License-Identifier: MIT
"""The accelerometer's nine constants from positions at rest: gravity's length is the same in all.

Tedaldi, Pretto, Menegatti 2014, eq. 9 and 10: minimise sum (|M (a_k - b)| - g)^2, M a lower
triangle. No position need be exact or level. What the positions do not tell stays near the ideal,
by the spread that the datasheet gives (PS-MPU-6000A-00 rev 3.4, p. 13), and its sigma says so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from terazi.applications.attitude.calibrated import LOWER
from terazi.calibration.imu.least_squares import solve
from terazi.calibration.imu.quantise import Constants
from terazi.units import ACC_COUNTS_PER_STANDARD_GRAVITY as ONE_G

# One sigma: scale +-3 %, cross axes +-2 %, zero +-50 to 80 mg at 25 degC and more when soldered.
PRIOR_SCALE, PRIOR_CROSS, PRIOR_OFFSET_G = 0.03, 0.02, 0.10
LEAST_SIGMA_G = 0.0003  # of a position: a table that gives, a floor that trembles


@dataclass(frozen=True)
class AccelerometerFit:
    """Sigmas in g and shares; of scale, cross axes and offset the worst."""

    constants: Constants
    residuals_g: np.ndarray  # (k,) |.| - 1 of each position, unrounded
    scale_sd: float
    cross_sd: float
    offset_sd_g: float


def fit_accelerometer(means_counts: np.ndarray, sigma_g: np.ndarray) -> AccelerometerFit:
    """means_counts : (k, 3), six or more positions;  sigma_g : (k,) of each mean."""
    means_g = np.asarray(means_counts) / ONE_G
    sigma_g = np.maximum(sigma_g, LEAST_SIGMA_G)
    prior = [PRIOR_SCALE if row == column else PRIOR_CROSS for row, column in LOWER]

    def constants(x: np.ndarray) -> Constants:
        matrix = np.eye(3)
        for place, value in zip(LOWER, x[:6], strict=True):
            matrix[place] += value
        return Constants(matrix, x[6:] * ONE_G)

    def away_g(x: np.ndarray) -> np.ndarray:
        return np.linalg.norm(constants(x).apply(means_g * ONE_G), axis=1) / ONE_G - 1.0

    solution = solve(
        lambda x: away_g(x) / sigma_g, np.zeros(9), np.array([*prior, *([PRIOR_OFFSET_G] * 3)])
    )
    sds = dict(zip(LOWER, solution.sd, strict=False))
    return AccelerometerFit(
        constants=constants(solution.x),
        residuals_g=away_g(solution.x),
        scale_sd=max(sds[at, at] for at in range(3)),
        cross_sd=max(sd for (row, column), sd in sds.items() if row != column),
        offset_sd_g=float(solution.sd[6:].max()),
    )
