# SPDX-License-Identifier: MIT
"""The magnetometer's offset (hard iron) and matrix (soft iron): an ellipsoid becomes a sphere.

While a board is turned about, the earth's field has one length; what is measured lies on an
ellipsoid. Its quadric by linear least squares (Li, Griffiths 2004) starts the true fit of
|M (m - b)| = F, with M symmetric and det M = 1: which way the part sits, a length does not tell,
and the counts keep their scale.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from terazi.calibration.imu.least_squares import solve
from terazi.calibration.imu.quantise import Constants
from terazi.errors import CalibrationRefused

SAMPLES_LEAST = 100
SIGMA = 0.01  # of a length: the part's noise and a field that differs from place to place
COVERED_LEAST = 0.7  # of 98 directions; half a sphere covers 0.67
DIRECTION_COSINE = 0.94  # 20 degrees
KNOWN_SD = 0.01
OUTLIER = 0.08  # of the field, from the first fit
OUTLIERS_MOST = 0.1
RAIL = 32767
TURN_MORE = "Turn it slowly about all its axes, until every side has looked everywhere."


@dataclass(frozen=True)
class MagnetometerFit:
    """field_counts: the length that all have after M."""

    constants: Constants
    field_counts: float
    residuals: np.ndarray  # of each sample used, in shares of the field
    matrix_sd: float
    left_out: int


def fit_magnetometer(raw_counts: np.ndarray) -> MagnetometerFit:
    """raw_counts : (n, 3). Raises CalibrationRefused: too few, at a rail, all on one side."""
    raw = np.unique(np.asarray(raw_counts), axis=0).astype(np.float64)
    if len(raw) < SAMPLES_LEAST:
        raise CalibrationRefused(
            f"{len(raw)} different values of the magnetometer are too few", remedy=TURN_MORE
        )
    if np.abs(raw).max() >= RAIL:
        raise CalibrationRefused(
            "the magnetometer is at its rail", remedy="Move it away from iron and magnets."
        )
    constants, field = _fit(raw, *_quadric(raw))
    lengths = np.linalg.norm(constants.apply(raw), axis=1) / field - 1
    near = np.abs(lengths) < OUTLIER
    if near.mean() < 1 - OUTLIERS_MOST:
        raise CalibrationRefused(
            f"the field differs by more than {OUTLIER:.0%} at {1 - near.mean():.0%} of the "
            "samples: no ellipsoid goes through them",
            remedy="Turn it in one place, away from iron, magnets and cables with current.",
        )
    raw = raw[near]
    constants, field = _fit(raw, constants, field)
    covered = coverage(constants.apply(raw))
    sd = _matrix_sd(raw, constants, field)
    if covered < COVERED_LEAST or sd > KNOWN_SD:
        raise CalibrationRefused(
            f"the field was seen from {covered:.0%} of all directions only", remedy=TURN_MORE
        )
    residuals = np.linalg.norm(constants.apply(raw), axis=1) / field - 1
    return MagnetometerFit(constants, field, residuals, sd, int((~near).sum()))


def coverage(vectors: np.ndarray) -> float:
    """Share of all directions that one of (n, 3) vectors comes near to."""
    lengths = np.linalg.norm(vectors, axis=1)
    units = vectors[lengths > 0] / lengths[lengths > 0, None]
    grid = directions()
    return float(np.mean([np.any(units @ each > DIRECTION_COSINE) for each in grid]))


def directions(count: int = 98) -> np.ndarray:
    """(count, 3) unit vectors, evenly over the sphere (a Fibonacci spiral)."""
    at = np.arange(count)
    z = 1 - (2 * at + 1) / count
    angle = at * np.pi * (3 - np.sqrt(5))
    level = np.sqrt(1 - z * z)
    return np.column_stack([level * np.cos(angle), level * np.sin(angle), z])


def _quadric(raw: np.ndarray) -> tuple[Constants, float]:
    """The ellipsoid x'Qx + 2 u'x = 1 through the points, as M and b."""
    size = np.abs(raw - raw.mean(axis=0)).max()
    x, y, z = ((raw - raw.mean(axis=0)) / size).T
    columns = np.column_stack(
        [x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z, 2 * x, 2 * y, 2 * z]
    )
    a, *_rest = np.linalg.lstsq(columns, np.ones(len(x)), rcond=None)
    q = np.array([[a[0], a[3], a[4]], [a[3], a[1], a[5]], [a[4], a[5], a[2]]])
    try:
        centre = -np.linalg.solve(q, a[6:])
        values, vectors = np.linalg.eigh(q / (1 + centre @ q @ centre))
    except np.linalg.LinAlgError:
        values = np.zeros(3)
    if values.min() <= 0:
        raise CalibrationRefused("the magnetometer's values lie on no ellipsoid", remedy=TURN_MORE)
    root = vectors @ np.diag(np.sqrt(values)) @ vectors.T
    scale = np.cbrt(np.linalg.det(root))
    return Constants(root / scale, centre * size + raw.mean(axis=0)), size / scale


def _fit(raw: np.ndarray, start: Constants, field: float) -> tuple[Constants, float]:
    """Least squares of the lengths themselves, from a start."""
    solution = solve(lambda x: _lengths(raw, start, field, x), np.zeros(9), np.full(9, np.inf))
    more, offset = _unpacked(solution.x)
    matrix = more @ start.matrix
    # A product of symmetric matrices is none: its polar decomposition's symmetric part turns
    # nothing and has the same lengths.
    values, vectors = np.linalg.eigh(matrix.T @ matrix)
    root = vectors @ np.diag(np.sqrt(values)) @ vectors.T
    scale = np.cbrt(np.linalg.det(root))
    return Constants(root / scale, start.offset_counts + offset * field), field / scale


def _lengths(raw: np.ndarray, start: Constants, field: float, x: np.ndarray) -> np.ndarray:
    more, offset = _unpacked(x)
    at = Constants(more @ start.matrix, start.offset_counts + offset * field)
    return (np.linalg.norm(at.apply(raw), axis=1) / field - 1) / SIGMA


def _unpacked(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    xx, yy, zz, xy, xz, yz = x[:6]
    more = np.eye(3) + np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return more, x[6:]


def _matrix_sd(raw: np.ndarray, constants: Constants, field: float) -> float:
    solution = solve(lambda x: _lengths(raw, constants, field, x), np.zeros(9), np.full(9, np.inf))
    return float(solution.sd[:6].max())
