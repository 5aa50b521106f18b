# SPDX-License-Identifier: MIT
"""Gain schedules of the scalar Kalman filter, quantised to what weight_kf.h takes."""

from __future__ import annotations

import math

ONE_Q15 = 32768
LEN_MAX = 255


def gain_schedule(*, process_var, noise_var, initial_var, steady_within=None, length=None):
    """Gains K[0], K[1], ... of the scalar filter, which depend on no data.

    process_var, noise_var, initial_var : Q, R and P before the first measurement, counts^2, any
        common scale; initial_var may be infinite (the first gain is then 1).
    steady_within : end where K is this close to its limit, relative; or length : this many gains.
    Returns list of float.

    Weighing thesis, eq. 3.7-3.11: P = P + Q; K = P / (P + R); P = (1 - K) P.
    """
    if (steady_within is None) == (length is None):
        raise ValueError("say either steady_within or length")
    # The positive root of P^2 - Q P - Q R = 0 is the variance before a steady update.
    steady_var = (process_var + math.sqrt(process_var**2 + 4 * process_var * noise_var)) / 2
    steady_gain = steady_var / (steady_var + noise_var)
    gains, variance = [], initial_var
    while len(gains) < (length or LEN_MAX + 1):
        variance += process_var
        gain = 1.0 if math.isinf(variance) else variance / (variance + noise_var)
        gains.append(gain)
        # (1 - K) P = K R, which holds for an infinite P, too.
        variance = gain * noise_var
        if steady_within is not None and abs(gain - steady_gain) <= steady_within * steady_gain:
            return gains
    if len(gains) > LEN_MAX:
        raise ValueError(f"schedule needs more than {LEN_MAX} gains: Q is too small beside R")
    return gains


def quantise_q15(gains):
    """Gains to the nearest Q15, at least 1 so that the filter never stands still.

    gains : floats in (0, 1].  Returns list of int, 1..32768.
    """
    return [min(ONE_Q15, max(1, math.floor(gain * ONE_Q15 + 0.5))) for gain in gains]
