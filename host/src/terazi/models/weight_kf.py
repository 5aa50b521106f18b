# SPDX-License-Identifier: MIT
"""Float64 truth for weight_kf.c."""

from __future__ import annotations

import math

import numpy as np

from terazi.design import specs

COUNTS_MIN, COUNTS_MAX = -(1 << 23), (1 << 23) - 1
HALF_STEP_COUNTS = 1 / 256  # half of the estimate's Q7
FLOAT_ERROR_COUNTS = 1e-6


def gains(schedule="default", count=None):
    """(count,) float64: the true gain of each update; count None: as many as the C's table has.

    Eq. 3.7-3.11 of the weighing thesis without end; a schedule of stated `length` holds its last.
    """
    entry = specs.weight_kf_schedule(schedule)
    table = specs.weight_kf_gains(schedule)
    wanted = len(table) if count is None else count
    found = list(table[:wanted])
    while len(found) < wanted:
        if "length" in entry:
            found.append(table[-1])
            continue
        noise_var = entry["noise_var"]
        variance = found[-1] * noise_var + entry["process_var"]  # (1 - K) P = K R
        found.append(variance / (variance + noise_var))
    return np.array(found)


def _table(schedule, count):
    """(count,) float64: the gains of the C, of which the last is held."""
    table = np.array(specs.weight_kf_gains_q15(schedule)) / 32768.0
    return table[np.minimum(np.arange(count), table.size - 1)]


def _measured(measured_counts):
    return np.clip(np.asarray(measured_counts, dtype=np.float64), COUNTS_MIN, COUNTS_MAX)


def weight_kf(measured_counts, *, schedule="default", first_counts=None, rounded_gain=False):
    """Float64 truth for ``weight_kf_update`` over a run of measurements.

    measured_counts : (n,) numbers, uniform sampling, no NaN.
    schedule : name or index of weight_kf.toml.
    first_counts : where the estimate starts; None: the first measurement.
    rounded_gain : with the gains that the C's table has; False: the true ones.
    Returns (n,) float64 counts (the C gives them in Q7).

    Weighing thesis, eq. 3.7-3.11: x += K (z - x). The C rounds the gain to Q15 and the estimate
    to 1/128 count and holds the last gain of its table; error_budget_counts and
    shared_c/notes/weight_kf.md bound the difference.
    """
    measured = _measured(measured_counts)
    if measured.size == 0:
        return measured
    estimate = measured[0] if first_counts is None else float(_measured(first_counts))
    estimates = np.empty_like(measured)
    taken = _table(schedule, measured.size) if rounded_gain else gains(schedule, measured.size)
    pairs = zip(measured.tolist(), taken.tolist(), strict=True)
    for n, (z, gain) in enumerate(pairs):
        estimate += gain * (z - estimate)
        estimates[n] = estimate
    return estimates


def error_budget_counts(
    measured_counts, *, schedule="default", first_counts=None, input_error_counts=0.0
):
    """Bound of |C - model| in counts after each update, shared_c/notes/weight_kf.md.

    measured_counts, schedule, first_counts : as for weight_kf.
    input_error_counts : bound of |C's measurement - model's|, where a FIR lies before both.
    Returns (n,) float64:  e' = (1 - k) e + |k - K| |z - x| + k input_error + half a step
    with k the C's gain, K the true one, x the model's estimate before the update.
    """
    measured = _measured(measured_counts)
    if measured.size == 0:
        return measured
    first = measured[0] if first_counts is None else float(_measured(first_counts))
    before = np.concatenate(
        [[first], weight_kf(measured, schedule=schedule, first_counts=first_counts)[:-1]]
    )
    innovation = np.abs(measured - before)
    c_gain = _table(schedule, measured.size)
    added = np.abs(c_gain - gains(schedule, measured.size)) * innovation
    added += c_gain * input_error_counts + HALF_STEP_COUNTS
    error = input_error_counts if first_counts is None else 0.0
    errors = np.empty_like(measured)
    for n, (gain, more) in enumerate(zip(c_gain.tolist(), added.tolist(), strict=True)):
        error = (1 - gain) * error + more
        errors[n] = error
    return errors + FLOAT_ERROR_COUNTS


def steady_variance_counts2(schedule="default"):
    """Variance of the estimate in the long run, as the filter itself believes: K R."""
    entry = specs.weight_kf_schedule(schedule)
    process_var, noise_var = entry["process_var"], entry["noise_var"]
    variance = (process_var + math.sqrt(process_var**2 + 4 * process_var * noise_var)) / 2
    return variance / (variance + noise_var) * noise_var
