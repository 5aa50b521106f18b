# SPDX-License-Identifier: MIT
"""Equiripple low-passes (Parks and McClellan 1972) by scipy, the extra `design`."""

from __future__ import annotations

PASSBAND_LEAST_BINS = 0.05  # a band of no width has no ripple to equalise


def lowpass(taps, pass_to_hz, stop_from_hz, rate_hz, *, stop_weight=1.0):
    """(taps,) float64, symmetric, sum 1: the least largest error in both bands.

    stop_weight : how many times less error in the stop band than in the pass band.
    """
    import numpy as np
    from scipy.signal import remez

    if taps < 2:
        raise ValueError(f"at least 2 taps are needed, not {taps}")
    pass_to_hz = max(pass_to_hz, PASSBAND_LEAST_BINS * rate_hz / taps)
    if not pass_to_hz < stop_from_hz < rate_hz / 2:
        raise ValueError(
            f"the stop band must begin between {pass_to_hz:g} Hz and {rate_hz / 2:g} Hz, "
            f"not at {stop_from_hz:g} Hz"
        )
    bands = [0, pass_to_hz, stop_from_hz, rate_hz / 2]
    try:
        response = remez(taps, bands, [1, 0], weight=[1, stop_weight], fs=rate_hz, maxiter=100)
    except ValueError as error:
        raise ValueError(f"no equiripple filter of {taps} taps found: {error}") from None
    if not np.all(np.isfinite(response)) or abs(response.sum()) < 0.1:
        raise ValueError(f"no equiripple filter of {taps} taps found for these bands")
    response = (response + response[::-1]) / 2
    return response / response.sum()
