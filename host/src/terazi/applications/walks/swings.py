# SPDX-License-Identifier: MIT
"""Do the two sensors tell of one motion? Between two stances a foot starts from rest and comes to
rest: acceleration, turned by the angular rate and less gravity, adds up to no velocity.

Where the rate of the samples, the gyroscope's range or the sign of an axis is wrong, the foot seems
tilted in its swing, and gravity leaks in: how much of it is told. By the default detector the 39
recorded walks have 0.006 to 0.083; with their rate or range off by two or an axis turned round,
nine in ten of them have more than 0.12.
"""

from __future__ import annotations

import numpy as np

from terazi.applications.walks.detectors import GRAVITY_M_S2
from terazi.applications.walks.record import Walk
from terazi.applications.walks.steps import stances

SWING_S = (0.2, 2.5)
BEFORE_S, AFTER_S = 0.15, 0.05  # of the stances at both ends
SWINGS_MOST, SWINGS_LEAST = 30, 3
LEAK_MOST = 0.12


def gravity_leak(walk: Walk, still: np.ndarray) -> float | None:
    """Median over some swings of the velocity that is left at the end, by gravity and duration;
    None where there are too few.

    still : (n,) bool, zero velocity.
    """
    spans = stances(still, walk.rate_hz)
    if len(spans) < 2:
        return None
    leaves, lands = spans[:-1, 1], spans[1:, 0]
    begin = np.maximum(spans[:-1, 0], leaves - round(BEFORE_S * walk.rate_hz))
    end = np.minimum(spans[1:, 1], lands + round(AFTER_S * walk.rate_hz)) - 1
    long_s = walk.t_s[lands] - walk.t_s[leaves]
    fit = np.flatnonzero((long_s > SWING_S[0]) & (long_s < SWING_S[1]))
    if len(fit) < SWINGS_LEAST:
        return None
    fit = fit[np.unique(np.linspace(0, len(fit) - 1, SWINGS_MOST).astype(np.int64))]
    up_b = np.array(
        [
            walk.acc_b_m_s2[first:last].mean(axis=0)
            for first, last in zip(begin[fit], leaves[fit], strict=True)
        ]
    )
    up_b *= GRAVITY_M_S2 / np.linalg.norm(up_b, axis=1, keepdims=True)
    left_m_s = _velocity_left(walk, begin[fit], end[fit], up_b)
    lasts_s = walk.t_s[end[fit]] - walk.t_s[begin[fit]]
    return float(np.median(np.linalg.norm(left_m_s, axis=1) / (GRAVITY_M_S2 * lasts_s)))


def _velocity_left(walk: Walk, begin, end, up_b: np.ndarray) -> np.ndarray:
    """(m, 3) in the axes of each swing's begin, where `up_b` balances gravity; all at once."""
    dt_s = walk.dt_s
    turned = np.tile(np.eye(3), (len(begin), 1, 1))
    velocity = np.zeros((len(begin), 3))
    for step in range(int((end - begin).max())):
        at = np.minimum(begin + step, len(walk) - 1)
        lasts_s = np.where(begin + step < end, dt_s[at], 0.0)[:, None]
        force = np.einsum("mij,mj->mi", turned, walk.acc_b_m_s2[at])
        velocity += (force - up_b) * lasts_s
        turned = turned @ _rotations(walk.rates.known_b_rad_s[at] * lasts_s)
    return velocity


def _rotations(angles: np.ndarray) -> np.ndarray:
    """(m, 3, 3) of (m, 3) rotation vectors (Rodrigues)."""
    size = np.maximum(np.linalg.norm(angles, axis=1), 1e-12)[:, None, None]
    x, y, z = angles.T
    zero = np.zeros_like(x)
    cross = np.moveaxis(np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]), -1, 0)
    bend = (1 - np.cos(size)) / size**2
    return np.eye(3) + np.sin(size) / size * cross + bend * cross @ cross


def swing_note(walk: Walk, still: np.ndarray) -> tuple[str, ...]:
    """A doubt about rate, range or axes, where swings do not end at rest."""
    leak = gravity_leak(walk, still)
    if leak is None or leak <= LEAK_MOST:
        return ()
    return (
        f"acceleration and turning do not tell of one motion: in a usual swing {100 * leak:.0f} % "
        f"of gravity are left over, where {100 * LEAK_MOST:.0f} % are much. Is the rate of the "
        "samples wrong, the gyroscope's range, the sign or order of an axis, or where the detector "
        "sees the foot stand?",
    )
