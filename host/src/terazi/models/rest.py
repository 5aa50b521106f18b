# SPDX-License-Identifier: MIT
"""Float64 truth for rest.c."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from terazi.design import rest as design

STANDARD_GRAVITY_M_S2 = design.STANDARD_GRAVITY_M_S2
BIAS_STEP_COUNTS = 2.0**-16
GRAVITY_BUDGET_COUNTS = np.sqrt(3) * design.GRAVITY_STEP_COUNTS / 2


@dataclass(frozen=True)
class RestResult:
    """What rest gives after each sample."""

    at_rest: np.ndarray  # (n,) bool
    bias_rad_s: np.ndarray  # (n, 3) float64
    rejected: int
    implausible: int
    margin: float  # least distance of a decision from its limit, in counts of the sensor
    budget_rad_s: float  # |C - model| of the bias, if both decide alike


def rest(gyro_b_rad_s, acc_b_m_s2, *, rate_hz, **changed):
    """Float64 truth for ``rest_update`` over a run of samples.

    gyro_b_rad_s, acc_b_m_s2 : (n, 3) float64, n >= 1, uniform sampling. NaN, infinities and
        values at or beyond what the sensor can say are rejected and counted; the first sample
        starts the low-passes, so that it must be whole.
    changed : keys of rest.toml with another value.
    Returns a RestResult.

    The low-passes and limits are not rounded. The C compares whole counts of its low-passes, and
    gravity in steps of 256 (margin counts what is left of their error), so that it may decide
    otherwise where `margin` is below 2 counts; else the bias lies within budget_rad_s,
    shared_c/notes/rest.md.
    """
    tables = {**design.spec()["limits"], **design.spec()["times"], **changed}
    sensor = {**design.spec()["sensor"], **changed}
    scale = np.degrees(sensor["gyro_counts_per_deg_s"])  # counts per rad/s
    acc_scale = sensor["acc_counts_per_g"] / STANDARD_GRAVITY_M_S2
    timed = design.timing(rate_hz, tables)
    limits = {
        "enter": (tables["enter_acc_m_s2"], np.radians(tables["enter_gyro_deg_s"])),
        "leave": (tables["leave_acc_m_s2"], np.radians(tables["leave_gyro_deg_s"])),
    }
    bias_max = np.radians(tables["bias_max_deg_s"])
    gravity = [tables[f"gravity_{side}_g"] * STANDARD_GRAVITY_M_S2 for side in ("min", "max")]
    rails = (32766.5 / acc_scale, 32766.5 / scale)
    samples = np.hstack([acc_b_m_s2, gyro_b_rad_s])
    count = len(samples)

    low, bias, block = np.zeros(6), np.zeros(3), np.zeros(3)
    flags, biases = np.zeros(count, dtype=bool), np.zeros((count, 3))
    at_rest, known, rounds, blocks, rejected, implausible = False, False, 0, 0, 0, 0
    margin, budget = np.inf, np.zeros(3)
    for n in range(count):
        visit = n % 6
        sensor_at = visit // 3
        per = (acc_scale, scale)[sensor_at]
        value, still = samples[n, visit], True
        learns = at_rest and rounds == design.BLOCK_ROUNDS
        if learns and visit == 0:
            feels = np.linalg.norm(low[:3])
            far = min(abs(feels - limit) * acc_scale for limit in gravity)
            margin = min(margin, far - GRAVITY_BUDGET_COUNTS)
            if gravity[0] <= feels <= gravity[1]:
                blocks = min(blocks + 1, timed["gain_len"])
            else:
                implausible += 1
                rounds = 0
        elif learns and visit >= 3:
            axis, gain = visit - 3, design.gain(blocks)
            bias[axis] += gain * (block[axis] / design.BLOCK_ROUNDS - bias[axis])
            budget[axis] = (1 - gain) * budget[axis] + BIAS_STEP_COUNTS
        elif not np.isfinite(value) or abs(value) > rails[sensor_at]:
            rejected += 1
            still = False
        else:
            off = value - low[visit]
            limit = limits["leave" if at_rest else "enter"][sensor_at]
            margin = min(margin, abs(abs(off) - limit) * per)
            still = abs(off) <= limit
            low[visit] = low[visit] + timed["lowpass_gain"] * off if still else value
            if still and sensor_at == 1:
                margin = min(margin, abs(abs(low[visit]) - bias_max) * per)
                still = abs(low[visit]) <= bias_max
                if still and at_rest and rounds < design.BLOCK_ROUNDS:
                    block[visit - 3] = value + (block[visit - 3] if rounds else 0.0)
        if not still:
            at_rest, rounds = False, 0
        elif visit == 5:
            rounds += 1
            if not at_rest:
                if rounds == timed["still_rounds" if known else "first_rounds"]:
                    at_rest, rounds = True, 0
            elif rounds == design.BLOCK_ROUNDS + 1:
                known, rounds = True, 0
        flags[n], biases[n] = at_rest, bias
    return RestResult(
        flags, biases, rejected, implausible, float(margin), float(budget.max() / scale) + 1e-12
    )
