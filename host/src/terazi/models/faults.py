# SPDX-License-Identifier: MIT
"""Float64 truth for the noise that faults.c hears, and chances of a false alarm."""

from __future__ import annotations

import math

import numpy as np

TAPS = np.array([1.0, -4.0, 7.0, -8.0, 7.0, -4.0, 1.0])
"""(1 - 1/z)^4 (1 + 1/z^2), of counts."""

MOVE_COUNTS = 256.0
MOVE_MOST_COUNTS = 2047 * MOVE_COUNTS
BUDGET_COUNTS = 8 * MOVE_COUNTS  # moves rounded down to MOVE_COUNTS: shared_c/notes/faults.md
STIR_COUNTS = 512.0
NOISE_PASSES = float(np.sqrt(np.sum(TAPS**2)))


def rest(counts) -> np.ndarray:
    """What the filter leaves of (n,) counts, the first of which stood for ever before.

    The C rounds moves down to MOVE_COUNTS and limits them to MOVE_MOST_COUNTS; where none is
    limited it differs by less than BUDGET_COUNTS.
    """
    values = np.asarray(counts, dtype=np.float64)
    if not values.size:
        return values
    before = np.full(len(TAPS) - 1, values[0])
    return np.convolve(np.concatenate([before, values]), TAPS, mode="valid")


def passes(frequency_of_rate) -> np.ndarray:
    """Gain of the filter at frequencies given as parts of the conversion rate."""
    omega = 2 * np.pi * np.asarray(frequency_of_rate, dtype=np.float64)
    return (2 * np.sin(omega / 2)) ** 4 * np.abs(2 * np.cos(omega))


def repeat_chance(noise_counts: float, repeats: int) -> float:
    """Chance that white noise of so many counts rms gives the same count `repeats` times more.

    All of n + 1 rounded normal variates are equal with the chance sum p_k^(n + 1), which is
    (2 pi s^2)^(-n/2) / sqrt(n + 1) where s is above a count.
    """
    density = 1.0 / (math.sqrt(2 * math.pi) * noise_counts)
    return density**repeats / math.sqrt(repeats + 1)
