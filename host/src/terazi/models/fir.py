# SPDX-License-Identifier: MIT
"""Float64 truth for fir.c."""

from __future__ import annotations

import numpy as np

from terazi.design import specs

COUNTS_MIN, COUNTS_MAX = -(1 << 23), (1 << 23) - 1


def taps_q15(design="lowpass32"):
    """(N,) int64 coefficients of the C, in Q15."""
    return specs.fir_taps_q15(design)


def fir(samples_counts, *, design="lowpass32", first_counts=None):
    """Float64 truth for ``fir_update`` over a run of samples.

    samples_counts : (n,) numbers, uniform sampling, no NaN.
    design : name or index of fir.toml.
    first_counts : what the window holds before the first sample; None: the first sample.
    Returns (n,) float64 counts.

    y[n] = sum_k c[k] x[n-k] with the coefficients as designed, not rounded; samples and results
    are limited to 24 bits as in the C. The C rounds coefficients to Q15 and results to a count;
    error_budget_counts and shared_c/notes/fir.md bound the difference.
    """
    samples = np.clip(np.asarray(samples_counts, dtype=np.float64), COUNTS_MIN, COUNTS_MAX)
    if samples.size == 0:
        return samples
    taps = specs.fir_taps(design)
    first = samples[0] if first_counts is None else float(first_counts)
    first = min(max(first, COUNTS_MIN), COUNTS_MAX)
    window = np.concatenate([np.full(taps.size - 1, first), samples])
    # Of differences from the first, so that a large constant costs no float64 digits.
    results = first + np.convolve(window - first, taps, mode="valid")
    return np.clip(results, COUNTS_MIN, COUNTS_MAX)


def error_budget_counts(design="lowpass32", *, peak_to_peak_counts):
    """Bound of |C - model| in counts, shared_c/notes/fir.md.

    peak_to_peak_counts : range of the samples, first_counts included.
    """
    rounded = np.abs(specs.fir_taps_q15(design) / 32768.0 - specs.fir_taps(design)).sum()
    return 0.5 + rounded / 2 * peak_to_peak_counts + 1e-6
