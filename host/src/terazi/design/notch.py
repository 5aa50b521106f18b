# SPDX-License-Identifier: MIT
"""Zeros of a linear-phase FIR where a disturbance arrives, folded by the measured rate."""

from __future__ import annotations

import numpy as np


def folded_hz(frequency_hz, rate_hz):
    """Where a frequency appears once it is sampled at rate_hz: 0 to rate/2."""
    frequency_hz = np.asarray(frequency_hz, dtype=np.float64)
    return np.abs(frequency_hz - np.round(frequency_hz / rate_hz) * rate_hz)


def with_notches(response, frequencies_hz, rate_hz):
    """The nearest symmetric response whose gain is 0 at frequencies_hz and 1 for a constant.

    response : (N,) float64, symmetric.
    frequencies_hz : as they are in the world; they are folded here.
    Returns (N,) float64.

    Least squares under linear conditions, h' = h - A^T (A A^T)^-1 (A h - b), whose rows in A are
    cos(2 pi f (n - (N-1)/2) / rate), the amplitude of a symmetric filter at f.
    """
    response = np.asarray(response, dtype=np.float64)
    taps = response.size
    folded = np.unique(np.round(folded_hz(list(frequencies_hz), rate_hz), 9))
    # A filter of N taps cannot be 1 and 0 nearer to one another than about a bin of its DFT.
    near = [f"{each:.2f} Hz" for each in folded if each < rate_hz / taps / 2]
    if near:
        raise ValueError(
            f"at {rate_hz:g} samples a second a notch falls on {', '.join(near)}, where the weight "
            f"itself is: {taps} taps cannot tell them apart"
        )
    # A symmetric filter of even length is 0 at half the rate whatever its coefficients.
    if taps % 2 == 0:
        folded = folded[folded < rate_hz / 2 * (1 - 1e-6)]
    if folded.size + 1 > (taps + 1) // 2:
        raise ValueError(f"{folded.size} notches are too many for {taps} taps")
    centred = np.arange(taps) - (taps - 1) / 2
    rows = np.cos(2 * np.pi * np.outer(np.concatenate([[0.0], folded]), centred) / rate_hz)
    wanted = np.concatenate([[1.0], np.zeros(folded.size)])
    missing = rows @ (response / response.sum()) - wanted
    mended = response / response.sum() - rows.T @ np.linalg.lstsq(rows @ rows.T, missing)[0]
    return (mended + mended[::-1]) / 2  # symmetric to the last bit
