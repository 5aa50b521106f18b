# SPDX-License-Identifier: MIT
"""Float64 truth for zupt_gru.c: the network itself, its inputs drawn by root and logarithm."""

from __future__ import annotations

import numpy as np

from terazi.design.zupt_gru import Floats, Gate, asked, scores

STEP_MS = 5


def zupt_gru_inputs(gyro_b_rad_s, acc_b_m_s2, network: Floats) -> np.ndarray:
    """(n, 2) float64 | |a| - g | and |w| in tenths of an octave above their floors, 0..1."""
    away = np.abs(np.linalg.norm(acc_b_m_s2, axis=1) - network.gravity_m_s2)
    turning = np.linalg.norm(gyro_b_rad_s, axis=1)
    shares = np.column_stack([away / network.acc_floor_m_s2, turning / network.rate_floor_rad_s])
    return np.minimum(np.log2(np.maximum(shares, 1.0)) / 10, 1.0)


def zupt_gru(gyro_b_rad_s, acc_b_m_s2, *, network: Floats, gate: Gate, sample_ms: int):
    """Float64 truth for ``zupt_gru_update`` over a run of samples.

    gyro_b_rad_s, acc_b_m_s2 : (n, 3) float64, sample_ms from one to the next, no NaN.
    Returns (m,) int sample of each step, and (m,) float64 twice: the logit after it above that of
    `accept`, and what is asked of it: still where it is not below that. The C tells it with the
    sample after.

    Cho et al. 2014 with PyTorch's gates; shared_c/notes/zupt_gru.md has what the C rounds.
    """
    last_ms = (len(gyro_b_rad_s) - 1) * sample_ms
    at = np.arange(0, last_ms + sample_ms, STEP_MS) // sample_ms  # the newest sample there is
    at = at[at < len(gyro_b_rad_s)]
    inputs = zupt_gru_inputs(np.asarray(gyro_b_rad_s)[at], np.asarray(acc_b_m_s2)[at], network)
    found = scores(network, inputs)
    return at, found, asked(found, gate)
