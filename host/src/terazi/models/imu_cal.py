# SPDX-License-Identifier: MIT
"""Float64 truth for imu_cal.c, and how true constants become its configuration."""

from __future__ import annotations

import numpy as np

INT16_MIN, INT16_MAX = -32768, 32767
ROW_MAX, SLOPE_MAX, OFFSET_LIMIT = 32767, 1 << 14, 1 << 29  # imu_cal.h
STEP_Q16 = 2.0**-16


def imu_cal(
    raw_counts, *, matrix, offset_counts, slope_counts=(0.0, 0.0, 0.0), above_reference=0.0
):
    """Float64 truth for ``imu_cal_apply`` over a run of vectors.

    raw_counts : (n, 3) numbers; NaN stays NaN.
    matrix : (3, 3) M;  offset_counts, slope_counts : (3,), on raw axes.
    above_reference : temperature above the reference in its counts, scalar or (n,).
    Returns (n, 3) float64 counts, limited to int16.

    M (raw - offset - slope (T - T_ref)). The C rounds M - I, M offset and M slope to Q16 and the
    result to a count; error_budget_counts and shared_c/notes/imu_cal.md bound the difference.
    """
    raw = np.asarray(raw_counts, dtype=np.float64)
    warmth = np.broadcast_to(np.asarray(above_reference, dtype=np.float64), raw.shape[:1])
    off = np.asarray(offset_counts) + warmth[:, None] * np.asarray(slope_counts)
    return np.clip((raw - off) @ np.asarray(matrix).T, INT16_MIN, INT16_MAX)


def config(matrix, offset_counts, slope_counts=(0.0, 0.0, 0.0)):
    """Fields of imu_cal_config_t; ValueError where they would break its contract."""
    matrix = np.asarray(matrix, dtype=np.float64)
    fields = {
        "matrix_q16": np.rint((matrix - np.eye(3)) / STEP_Q16).astype(int).tolist(),
        "offset_q16": np.rint(matrix @ np.asarray(offset_counts) / STEP_Q16).astype(int).tolist(),
        "slope_q16": np.rint(matrix @ np.asarray(slope_counts) / STEP_Q16).astype(int).tolist(),
    }
    if max(sum(map(abs, row)) for row in fields["matrix_q16"]) > ROW_MAX:
        raise ValueError("a row of M - I sums to more than 0.5 in magnitude")
    if max(map(abs, fields["offset_q16"])) >= OFFSET_LIMIT:
        raise ValueError("an offset is 8192 counts or more")
    if max(map(abs, fields["slope_q16"])) > SLOPE_MAX:
        raise ValueError("a slope is above 0.25 counts a temperature count")
    return fields


def error_budget_counts(raw_counts, *, above_reference=0.0):
    """Bound of |C - model| in counts of each vector, shared_c/notes/imu_cal.md; (n,) float64.

    Half a count, half a step of Q16 for each product, the offset and the slope.
    """
    raw = np.abs(np.asarray(raw_counts, dtype=np.float64)).sum(axis=1)
    return 0.5 + STEP_Q16 / 2 * (raw + 1.0 + np.abs(above_reference)) + 1e-9
