# SPDX-License-Identifier: MIT
"""Linear-phase FIR: frequency sampling, quantising to what fir.h takes, and what a filter does."""

from __future__ import annotations

import numpy as np

ONE_Q15 = 32768


def frequency_sampling(taps, magnitudes):
    """Impulse response with given magnitudes at the bins of its own DFT.

    taps : number of coefficients, N.
    magnitudes : (m,) float64, m <= N/2 + 1, wanted |H| at k rate/N for k = 0..m-1; 0 beyond.
    Returns (N,) float64, symmetric; H(0) is exactly magnitudes[0].

    Weighing thesis, frequency sampling; Rabiner and Gold 1975, ch. 3 (type 1 sampling):
    h[n] = (H_0 + 2 sum_k H_k cos(2 pi k (n - (N-1)/2) / N)) / N, k = 1 .. below N/2.  For even N
    a linear-phase filter has H = 0 at half the rate, so a wish there cannot be met.
    """
    magnitudes = np.asarray(magnitudes, dtype=np.float64)
    if taps < 2:
        raise ValueError(f"at least 2 taps are needed, not {taps}")
    bins = (taps + 1) // 2  # those below half the rate
    if np.any(magnitudes[bins:]):
        raise ValueError("there is no bin to sample there; an even filter is 0 at half the rate")
    centred = np.arange(taps) - (taps - 1) / 2
    response = np.full(taps, magnitudes[0])
    for k, magnitude in enumerate(magnitudes[1:bins], start=1):
        response += 2 * magnitude * np.cos(2 * np.pi * k * centred / taps)
    return response / taps


def quantise_q15(response):
    """Nearest symmetric Q15 coefficients whose sum is exactly 32768.

    response : (N,) float64, symmetric, sum near 1.
    Returns (N,) int64.

    Rounding alone leaves the sum off by a few; it is mended in pairs where that moves the value
    least against its rounding error (largest remainder), so that a constant passes unchanged. The
    middle one of an odd number must then be even.
    """
    response = np.asarray(response, dtype=np.float64)
    if response.ndim != 1 or response.size < 2 or not np.all(np.isfinite(response)):
        raise ValueError("a response is a row of at least 2 finite numbers")
    if not np.allclose(response, response[::-1], atol=1e-12, rtol=0):
        raise ValueError("response is not symmetric")
    wanted = response / response.sum() * ONE_Q15
    pairs = response.size // 2
    middle = [2 * np.floor(wanted[pairs] / 2 + 0.5)] if response.size % 2 else []
    half = wanted[:pairs]
    rounded = np.floor(half + 0.5)
    missing = int((ONE_Q15 - sum(middle)) // 2 - rounded.sum())
    # Stable order of how much each would like to be moved, ties by place: the same on any machine.
    wish = np.round((half - rounded) * np.sign(missing), 9)
    order = sorted(range(half.size), key=lambda k: (-wish[k], k))
    for turn in range(abs(missing)):
        rounded[order[turn % pairs]] += np.sign(missing)
    quantised = np.concatenate([rounded, middle, rounded[::-1]]).astype(np.int64)
    if quantised.sum() != ONE_Q15 or np.abs(quantised).sum() >= 2 * ONE_Q15:
        raise ValueError("coefficients break fir.h: sum 32768 and sum of magnitudes below 65536")
    if np.abs(quantised).max() > ONE_Q15 - 1:
        raise ValueError("a coefficient does not fit in Q15")
    return quantised


def magnitude_db(coefficients, frequencies_hz, rate_hz):
    """20 log10 |H| of coefficients (any scale; relative to their sum) at frequencies_hz."""
    coefficients = np.asarray(coefficients, dtype=np.float64)
    turns = np.outer(np.asarray(frequencies_hz) / rate_hz, np.arange(coefficients.size))
    gain = np.abs(np.exp(-2j * np.pi * turns) @ coefficients) / coefficients.sum()
    return 20 * np.log10(np.maximum(gain, 1e-12))


def noise_gain(coefficients):
    """Standard deviation out over in for white noise: sqrt(sum c^2) / sum c."""
    coefficients = np.asarray(coefficients, dtype=np.float64)
    return float(np.sqrt(np.square(coefficients).sum()) / coefficients.sum())


def settling_samples(coefficients, within):
    """Samples after a unit step until the answer stays within +-`within` of 1."""
    step = np.cumsum(np.asarray(coefficients, dtype=np.float64)) / np.sum(coefficients)
    outside = np.flatnonzero(np.abs(step - 1) > within)
    return int(outside[-1] + 2) if outside.size else 1


def delay_samples(coefficients):
    """Group delay of symmetric coefficients, in samples, the same at every frequency."""
    return (len(coefficients) - 1) / 2
