# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads over time, sampled ahead in blocks at the converter's own instants."""

import numpy as np


def as_function(load):
    """Return a function of an array of seconds for a number, ``(array, rate_hz)`` or callable.

    An array is interpolated linearly from second 0 and holds its last value. A callable may
    take an array or a single number; which of the two is found out once.
    """
    if callable(load):
        return _vectorised(load)
    if isinstance(load, tuple):
        values, rate_hz = load
        values = np.asarray(values, float)
        if values.ndim != 1 or not len(values):
            raise ValueError("a sampled load is a one-dimensional array with at least one value")
        at_s = np.arange(len(values)) / float(rate_hz)
        return lambda t_s: np.interp(t_s, at_s, values)
    value = float(load)
    return lambda t_s: np.full(np.shape(t_s), value)


def as_vectors(signal, width=3):
    """Return a function of (n,) seconds that gives (n, width) values.

    signal : ``width`` numbers, ``(array of width columns, rate_hz)`` or a function of (n,) seconds
    that gives (n, width), or (n,) where width is 1. Arrays are interpolated and hold their ends.
    """
    if callable(signal):
        return lambda t_s: np.asarray(signal(t_s), float).reshape(len(t_s), width)
    if isinstance(signal, tuple) and len(signal) == 2 and np.ndim(signal[0]) > 0:
        columns = np.asarray(signal[0], float).reshape(-1, width)
        at_s = np.arange(len(columns)) / float(signal[1])
        return lambda t_s: np.column_stack([np.interp(t_s, at_s, each) for each in columns.T])
    values = np.asarray(signal, float).reshape(width)
    return lambda t_s: np.tile(values, (len(t_s), 1))


def _vectorised(function):
    probe_s = np.array([0.0, 1e-3, 2e-3])
    try:
        answer = np.asarray(function(probe_s), float)
    except (TypeError, ValueError):
        answer = None
    if answer is not None and answer.shape == probe_s.shape:
        return lambda t_s: np.asarray(function(t_s), float)
    return np.vectorize(lambda t_s: float(function(float(t_s))), otypes=[float])
