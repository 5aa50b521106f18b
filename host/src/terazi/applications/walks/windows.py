# SPDX-License-Identifier: MIT
"""Moving means and minima over arrays, centred or over the past alone; spans of what is true."""

from __future__ import annotations

import numpy as np


def moving_mean(values: np.ndarray, length: int, *, causal: bool = False) -> np.ndarray:
    """(n,) or (n, k) means over `length` samples, fewer at the edges; centred: length is odd."""
    count = len(values)
    total = np.cumsum(values, axis=0, dtype=np.float64)
    total = np.concatenate([np.zeros_like(total[:1]), total])
    begin, end = _bounds(count, length, causal)
    size = (end - begin).reshape((-1,) + (1,) * (values.ndim - 1))
    return (total[end] - total[begin]) / size


def moving_variance(values: np.ndarray, length: int, *, causal: bool = False) -> np.ndarray:
    """(n,) variance of (n, k) vectors about their moving mean, summed over the axes."""
    centre = values - values[0]
    mean = moving_mean(centre, length, causal=causal)
    square = moving_mean(np.sum(centre**2, axis=1), length, causal=causal)
    return np.maximum(square - np.sum(mean**2, axis=1), 0.0)


def moving_min(values: np.ndarray, length: int, *, causal: bool = False) -> np.ndarray:
    """(n,) minima over `length` samples.

    At an edge a centred window does not shrink: what it lacks there it takes from the other side,
    for a short window that holds no stance would take a swing for one.
    """
    count = len(values)
    if count <= length:
        return np.minimum.accumulate(values) if causal else np.full(count, values.min())
    # Minima of whole blocks from both ends (van Herk 1992): two steps a sample.
    padded = np.concatenate([values, np.full(-count % length, np.inf)]).reshape(-1, length)
    ahead = np.minimum.accumulate(padded, axis=1).ravel()[:count]
    back = np.minimum.accumulate(padded[:, ::-1], axis=1)[:, ::-1].ravel()[:count]
    begin = np.arange(count - length + 1)
    whole = np.minimum(back[begin], ahead[begin + length - 1])
    if causal:
        return np.concatenate([np.minimum.accumulate(values[: length - 1]), whole])
    half = length // 2
    return whole[np.clip(np.arange(count) - half, 0, count - length)]


def spans(which: np.ndarray) -> np.ndarray:
    """(m, 2) first sample and first no longer in it, of each stretch of (n,) that is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], which, [False]]).astype(np.int8)))
    return edges.reshape(-1, 2)


def _bounds(count: int, length: int, causal: bool) -> tuple[np.ndarray, np.ndarray]:
    at = np.arange(count)
    if causal:
        return np.maximum(at - length + 1, 0), at + 1
    return np.maximum(at - length // 2, 0), np.minimum(at + length // 2 + 1, count)


def odd_length(seconds: float, rate_hz: float) -> int:
    """Samples of a window, an odd number and at least one."""
    return 2 * round((seconds * rate_hz - 1) / 2) + 1 if seconds * rate_hz > 1 else 1
