# SPDX-License-Identifier: MIT
"""Float64 truth for temperature.c, and how far the C may lie from it."""

from __future__ import annotations

import numpy as np

STEP_MAX_K = 4.0
SMOOTHING_GAIN = 1.0 / 16.0
SMOOTHED_BUDGET_K = 0.0451  # |C - model| of a smoothed temperature, shared_c/notes/temperature.md


def smooth(readings_c):
    """(n,) float64 smoothed temperature after each of (n,) readings, degC, all within range.

    The C keeps 1/200 K and gives 1/100 K: within SMOOTHED_BUDGET_K.
    """
    readings_c = np.asarray(readings_c, dtype=np.float64)
    smoothed = np.empty_like(readings_c)
    now = readings_c[0] if readings_c.size else 0.0
    for at, reading in enumerate(readings_c):
        now += SMOOTHING_GAIN * np.clip(reading - now, -STEP_MAX_K, STEP_MAX_K)
        smoothed[at] = now
    return smoothed


def correct(raw_counts, above_k, *, zero_counts_per_k, span_ppm_per_k, origin_counts):
    """(n,) float64 counts at the reference temperature.

    raw_counts : (n,) float64.    above_k : temperature above the reference, scalar or (n,).
    zero_counts_per_k, span_ppm_per_k : the drifts.    origin_counts : zero at the reference.

    c - zero dT - span dT (c - origin), not limited to 24 bits. Within error_budget_counts.
    """
    raw_counts = np.asarray(raw_counts, dtype=np.float64)
    share = span_ppm_per_k * 1e-6 * np.asarray(above_k, dtype=np.float64)
    return raw_counts - zero_counts_per_k * above_k - share * (raw_counts - origin_counts)


def error_budget_counts(raw_counts, above_k, *, zero_counts_per_k, span_ppm_per_k, origin_counts):
    """(n,) float64: |C - correct| is at most this; shared_c/notes/temperature.md derives it."""
    above_origin = np.abs(np.asarray(raw_counts, dtype=np.float64) - origin_counts)
    zero = abs(zero_counts_per_k * np.asarray(above_k, dtype=np.float64)) * 2e-9
    share = abs(span_ppm_per_k * 1e-6 * np.asarray(above_k, dtype=np.float64)) * 1e-9 + 2.0**-33
    return zero + above_origin * share + 2 * 2.0**-8 + 0.5
