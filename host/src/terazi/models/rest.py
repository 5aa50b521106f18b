# SPDX-License-Identifier: MIT
"""Float64 truth for rest.c."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from terazi.design import rest as design

STANDARD_GRAVITY_M_S2 = design.STANDARD_GRAVITY_M_S2
BIAS_STEP_COUNTS = 2.0**-16
GAIN_STEP = 2.0**-15


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

    The low-passes and limits are not rounded. The C compares whole counts of its low-passes, so
    that it may decide otherwise where `margin` is below 2 counts; else the bias lies within
    budget_rad_s, shared_c/notes/rest.md.
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

    low, bias, block = samples[0].copy(), np.zeros(3), np.zeros(3)
    flags, biases = np.zeros(count, dtype=bool), np.zeros((count, 3))
    at_rest, rounds, blocks, rejected, implausible = False, 0, 0, 0, 0
    margin, budget = np.inf, np.zeros(3)
    for n in range(count):
        visit = n % 6
        sensor_at = visit // 3
        per = (acc_scale, scale)[sensor_at]
        value, still = samples[n, visit], True
        if at_rest and rounds == design.BLOCK_ROUNDS + 1 and visit < 3:
            step = block[visit] / design.BLOCK_ROUNDS - bias[visit]
            gain = design.gain(blocks)
            bias[visit] += gain * step
            budget[visit] = (1 - gain) * budget[visit] + BIAS_STEP_COUNTS / 2
            budget[visit] += GAIN_STEP / 2 * abs(step) * scale
        elif not np.isfinite(value) or abs(value) > rails[sensor_at]:
            rejected += 1
            still = False
        else:
            off = value - low[visit]
            low[visit] += timed["lowpass_gain"] * off
            limit = limits["leave" if at_rest else "enter"][sensor_at]
            margin = min(margin, abs(abs(off) - limit) * per)
            still = abs(off) <= limit
            if sensor_at == 1:
                margin = min(margin, abs(abs(low[visit]) - bias_max) * per)
                still = still and abs(low[visit]) <= bias_max
                if still and at_rest and rounds < design.BLOCK_ROUNDS:
                    block[visit - 3] = value + (block[visit - 3] if rounds else 0.0)
        if not still:
            at_rest, rounds = False, 0
        elif visit == 5:
            rounds += 1
            if not at_rest:
                if rounds == timed["still_rounds"]:
                    at_rest, rounds = True, 0
            elif rounds == design.BLOCK_ROUNDS + 1:
                feels = np.linalg.norm(low[:3])
                margin = min(margin, *(abs(feels - limit) * acc_scale for limit in gravity))
                if gravity[0] <= feels <= gravity[1]:
                    blocks = min(blocks + 1, timed["gain_len"])
                else:
                    implausible += 1
                    rounds = 0
            elif rounds == design.BLOCK_ROUNDS + 2:
                rounds = 0
        flags[n], biases[n] = at_rest, bias
    return RestResult(
        flags, biases, rejected, implausible, float(margin), float(budget.max() / scale) + 1e-12
    )
