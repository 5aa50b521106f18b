# SPDX-License-Identifier: MIT
"""Linear-phase low-passes by windows: rectangular, Hamming, Hann, Blackman."""

from __future__ import annotations

import numpy as np

# Cosine sums a0 - a1 cos + a2 cos, Harris 1978, "On the use of windows for harmonic analysis with
# the discrete Fourier transform", Proc. IEEE 66(1), symmetric form.
WINDOWS = {
    "rectangular": (1.0,),
    "hamming": (0.54, 0.46),
    "hann": (0.5, 0.5),
    "blackman": (0.42, 0.5, 0.08),
}


def window(name, taps):
    """(taps,) float64 of a window in WINDOWS, symmetric, 1 in its middle."""
    if name not in WINDOWS:
        raise ValueError(f"no window {name!r}; there are {', '.join(WINDOWS)}")
    # Hann and Blackman are 0 at their ends: two coefficients that would be read for nothing. They
    # are taken two samples longer, and their ends left away.
    longer = 2 if name in ("hann", "blackman") else 0
    last = taps + longer - 1
    turns = np.arange(taps + longer) / last if last else np.full(1, 0.5)
    terms = [
        (-1) ** k * weight * np.cos(2 * np.pi * k * turns) for k, weight in enumerate(WINDOWS[name])
    ]
    values = np.sum(terms, axis=0)
    return values[longer // 2 : values.size - longer // 2]


def lowpass(name, taps, cutoff_hz, rate_hz):
    """(taps,) float64: the ideal low-pass's answer under a window, sum 1.

    cutoff_hz : where the ideal low-pass ends; 0: the window itself as a weighted mean, which is
        the narrowest that it can give.
    """
    if taps < 2:
        raise ValueError(f"at least 2 taps are needed, not {taps}")
    if not 0 <= cutoff_hz < rate_hz / 2:
        raise ValueError(f"a cut-off of {cutoff_hz} Hz does not lie below half of {rate_hz} Hz")
    centred = np.arange(taps) - (taps - 1) / 2
    ideal = np.sinc(2 * cutoff_hz / rate_hz * centred)
    response = ideal * window(name, taps)
    if response.sum() < 0.05 * np.abs(response).sum():
        raise ValueError(f"{taps} taps are too few for a cut-off of {cutoff_hz} Hz")
    return response / response.sum()
