# SPDX-License-Identifier: MIT
"""The shipped fixed-point chain over a recording: imu_cal, rest and mahony, sample by sample as on
the chip, start-up included and nothing of the future known."""

from __future__ import annotations

import numpy as np

from terazi.applications.attitude.trials import Trial
from terazi.cshared import ImuCal, Mahony, Rest
from terazi.design import mahony as mahony_design
from terazi.design import rest as rest_design

MODES = (6, 9)
FILTERS = tuple(mahony_design.MODES)
Q30 = 1 << 30


def estimate(
    trial: Trial,
    *,
    mode: int = 6,
    filter: str = "second_order",
    mahony: dict | None = None,
    rest: dict | None = None,
) -> np.ndarray:
    """(n, 4) float64 unit quaternions, body to world, scalar first, one after each sample.

    mode : 6 axes, or 9, with the magnetometer.
    mahony, rest : keys of mahony.toml and rest.toml with another value than the shipped one.

    The recording's sensors are taken as calibrated: imu_cal runs with its identity.
    """
    if mode not in MODES or filter not in FILTERS:
        raise ValueError(f"mode is one of {MODES}, filter one of {FILTERS}")
    gyro, acc = ImuCal().block(trial.gyro_b_counts), ImuCal().block(trial.acc_b_counts)
    still = Rest(rest_design.config_at(trial.rate_hz, **(rest or {})))
    turned = Mahony(mahony_design.config_at(trial.rate_hz, filter, **(mahony or {})))
    mag = ImuCal().block(trial.mag_b_counts) if mode == 9 else None
    return turned.block(gyro, acc, mag, rest=still) / Q30
