# SPDX-License-Identifier: MIT
"""Adaptive line enhancer: an LMS predictor that learns a rhythm and takes it off. Float only."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Enhanced(NamedTuple):
    """Both outputs of the line enhancer, (n,) float64 counts each."""

    line_counts: np.ndarray  # the rhythm, as predicted
    rest_counts: np.ndarray  # the samples without it: weight, noise, what is not yet learnt, and as
    # much of the rhythm as the mean lets pass, because it is not in what is learnt from


def line_enhancer(
    samples_counts, *, taps=32, delay_samples=1, step=0.005, mean_samples=32, guard_counts=1.0
):
    """Take what can be predicted from samples_counts but for their slow mean.

    samples_counts : (n,) numbers, uniform sampling. NaN is skipped: nothing is learnt from it, and
        the sample before stands in for it.
    taps : length of the predictor.  delay_samples : how far ahead it predicts, at least 1; noise
        whose correlation is longer than that would be predicted, too.
    step : of the normalised LMS, 0 < step < 2; small steps follow slowly and disturb little.
    mean_samples : the mean that is taken off before (a weight can be predicted better than anything
        else, and must not be).  guard_counts : keeps the division from zero in silence.
    Returns Enhanced.

    Widrow et al. 1975, "Adaptive noise cancelling", Proc. IEEE 63(12), self-tuning filter; its step
    normalised by the power in the line (Nagumo and Noda 1967):
    y = w . u, e = v - y, w += step e u / (guard^2 + u . u),
    u = v[n - delay .. n - delay - taps + 1]
    """
    if taps < 1 or delay_samples < 1 or mean_samples < 1:
        raise ValueError("taps, delay and mean are at least 1")
    if not 0 < step < 2:
        raise ValueError(f"a step of {step} does not converge: 0 < step < 2")
    samples = _without_gaps(samples_counts)
    if samples.size == 0:
        return Enhanced(samples, samples.copy())
    varying = samples - _running_mean(samples, mean_samples)
    padded = np.concatenate([np.zeros(taps + delay_samples - 1), varying])
    weights = np.zeros(taps)
    line = np.empty_like(samples)
    for n, value in enumerate(varying):
        past = padded[n : n + taps]  # the youngest of them is v[n - delay]
        line[n] = weights @ past
        gain = step / (guard_counts**2 + past @ past)
        weights += gain * (value - line[n]) * past
    return Enhanced(line, samples - line)


def _without_gaps(samples_counts):
    samples = np.array(samples_counts, dtype=np.float64)
    good = np.isfinite(samples)
    if not good.any():
        return samples[:0]
    last = np.maximum.accumulate(np.where(good, np.arange(samples.size), -1))
    return samples[np.where(last < 0, np.argmax(good), last)]


def _running_mean(samples, length):
    """Mean of the last `length` samples, as if the first had stood there for ever."""
    first = samples[0]
    sums = np.cumsum(np.concatenate([np.zeros(length), samples - first]))
    return first + (sums[length:] - sums[:-length]) / length
