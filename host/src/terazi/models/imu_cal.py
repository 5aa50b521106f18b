# SPDX-License-Identifier: MIT
"""Float64 truth for imu_cal.c, and how true constants become its configuration."""

from __future__ import annotations

import numpy as np

INT16_MIN, INT16_MAX = -32768, 32767
ROW_MAX, SLOPE_MAX = 32767, 1 << 14  # imu_cal.h
STEP_Q16, STEP_Q3 = 2.0**-16, 2.0**-3
AXIS_NAMES = "xyz"
ORIENTATIONS = {
    f"{'pn'[x_negated]}{AXIS_NAMES[x]}_{'pn'[y_negated]}{AXIS_NAMES[y]}": x
    | x_negated << 2
    | y << 3
    | y_negated << 5
    for x in range(3)
    for x_negated in range(2)
    for y in range(3)
    for y_negated in range(2)
    if x != y
}
"""How a part can stand: name, as px_nz, and code of imu_cal.h. The board's x points along the
part's x, its y against the part's z."""


def imu_cal(
    raw_counts, *, matrix, offset_counts, slope_counts=(0.0, 0.0, 0.0), above_reference=0.0
):
    """Float64 truth for ``imu_cal_apply`` over a run of vectors.

    raw_counts : (n, 3) numbers; NaN stays NaN.
    matrix : (3, 3) M;  offset_counts, slope_counts : (3,), on raw axes.
    above_reference : temperature above the reference in its counts, scalar or (n,).
    Returns (n, 3) float64 counts, limited to int16.

    M (raw - offset - slope (T - T_ref)). The C rounds M - I and M slope to Q16, M offset to Q3 and
    the result to a count; error_budget_counts and shared_c/notes/imu_cal.md bound the difference.
    """
    raw = np.asarray(raw_counts, dtype=np.float64)
    warmth = np.broadcast_to(np.asarray(above_reference, dtype=np.float64), raw.shape[:1])
    off = np.asarray(offset_counts) + warmth[:, None] * np.asarray(slope_counts)
    return np.clip((raw - off) @ np.asarray(matrix).T, INT16_MIN, INT16_MAX)


def orientation_matrix(orientation):
    """(3, 3) float64, the rotation from the part's axes to the board's; float64 truth for
    ``imu_cal_turn``, but for its limit at 32767."""
    if orientation not in ORIENTATIONS.values():
        raise ValueError(f"no orientation {orientation}")
    rotation = np.zeros((3, 3))
    for row, shift in enumerate((0, 3)):
        code = orientation >> shift
        rotation[row, code & 3] = -1.0 if code & 4 else 1.0
    rotation[2] = np.cross(rotation[0], rotation[1])
    return rotation


def config(matrix, offset_counts):
    """Fields of imu_cal_config_t; ValueError where they would break its contract."""
    matrix = np.asarray(matrix, dtype=np.float64)
    fields = {
        "matrix_q16": np.rint((matrix - np.eye(3)) / STEP_Q16).astype(int).tolist(),
        "offset_q3": np.rint(matrix @ np.asarray(offset_counts) / STEP_Q3).astype(int).tolist(),
    }
    if max(sum(map(abs, row)) for row in fields["matrix_q16"]) > ROW_MAX:
        raise ValueError("a row of M - I sums to more than 0.5 in magnitude")
    if max(map(abs, fields["offset_q3"])) > INT16_MAX:
        raise ValueError("an offset is 4096 counts or more")
    return fields


def slope_q16(matrix, slope_counts):
    """What imu_cal_at_temperature takes of slopes on raw axes; ValueError beyond its contract."""
    slope = np.rint(np.asarray(matrix) @ np.asarray(slope_counts) / STEP_Q16).astype(int).tolist()
    if max(map(abs, slope)) > SLOPE_MAX:
        raise ValueError("a slope is above 0.25 counts a temperature count")
    return slope


def error_budget_counts(raw_counts, *, above_reference=None):
    """Bound of |C - model| in counts of each vector, shared_c/notes/imu_cal.md; (n,) float64.

    Half a count, half a step of Q3 for the offset and half a step of Q16 for each product; at
    another temperature than the reference's half a step of the slope and of Q3 once more.
    """
    raw = np.abs(np.asarray(raw_counts, dtype=np.float64)).sum(axis=1)
    budget = 0.5 + STEP_Q3 / 2 + STEP_Q16 / 2 * raw + 1e-9
    if above_reference is not None:
        budget = budget + STEP_Q3 / 2 + STEP_Q16 / 2 * np.abs(above_reference)
    return budget
