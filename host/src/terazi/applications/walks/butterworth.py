# SPDX-License-Identifier: MIT
"""Butterworth filters of first order, as the walks' published detector has them; no SciPy."""

from __future__ import annotations

import math

import numpy as np


class Butterworth:
    """One pole, by the bilinear transform with its frequency warped to fit.

    corner_hz : where the response is 1 / sqrt 2.  high : a high-pass.
    """

    def __init__(self, corner_hz: float, rate_hz: float, *, high: bool = False) -> None:
        if not 0 < corner_hz < rate_hz / 2:
            raise ValueError(f"a corner of {corner_hz:g} Hz at {rate_hz:g} samples a second")
        warped = math.tan(math.pi * corner_hz / rate_hz)
        self._pole = (1 - warped) / (1 + warped)
        self._gain = (1.0 if high else warped) / (1 + warped)
        self._sign = -1.0 if high else 1.0

    def forward(self, values: np.ndarray) -> np.ndarray:
        """(n,): nothing of the future; starts as if the first value had always been there."""
        values = np.asarray(values, dtype=np.float64)
        before = np.concatenate([values[:1], values[:-1]])
        driven = (self._gain * (values + self._sign * before)).tolist()
        state = float(values[0]) if self._sign > 0 else 0.0
        out, pole = [], self._pole
        for each in driven:
            state = pole * state + each
            out.append(state)
        return np.array(out)

    def both_ways(self, values: np.ndarray) -> np.ndarray:
        """(n,) without delay: forward, then backward."""
        return self.forward(self.forward(values)[::-1])[::-1]
