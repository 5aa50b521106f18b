# SPDX-License-Identifier: MIT
"""True constants of a sensor as the device's settings hold them, and what its integers make of it.

true = M (raw - offset) becomes raw + D raw - o with D = M - I in Q16 and o = M offset in Q3
(imu_cal.h). An accelerometer's D is a lower triangle: which way a board is turned, gravity's
length does not tell.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from terazi.cshared import ImuCal
from terazi.errors import CalibrationRefused

AXES = "xyz"
ROW_MAX = 32767  # sum of |D| in Q16, imu_cal.h
OFFSET_MAX_COUNTS = 4095
LOWER = tuple((row, column) for row in range(3) for column in range(row + 1))
SQUARE = tuple((row, column) for row in range(3) for column in range(3))
PLACES = {"acc": LOWER, "gyro": SQUARE, "mag": SQUARE}  # of matrix_q16, in the order of its keys
SENSORS = {"acc": "accelerometer", "gyro": "gyroscope", "mag": "magnetometer"}


@dataclass(frozen=True)
class Constants:
    """What one sensor needs, in its raw counts."""

    matrix: np.ndarray  # (3, 3) M
    offset_counts: np.ndarray  # (3,) on raw axes

    def apply(self, raw) -> np.ndarray:
        """Unrounded, for fits."""
        return (np.asarray(raw, dtype=np.float64) - self.offset_counts) @ self.matrix.T


def setting_names(group: str) -> list[str]:
    """Of matrix, then offset, by the order of their keys."""
    matrix = [f"{group}.{AXES[row]}{AXES[column]}_q16" for row, column in PLACES[group]]
    return matrix + [f"{group}.offset_q3_{at}" for at in range(3)]


def settings_of(group: str, constants: Constants) -> dict[str, int]:
    """Settings by name. Raises CalibrationRefused where the device cannot hold them."""
    d_q16 = np.rint((constants.matrix - np.eye(3)) * (1 << 16)).astype(int)
    after_counts = constants.matrix @ constants.offset_counts
    if np.abs(d_q16).sum(axis=1).max() > ROW_MAX:
        raise CalibrationRefused(
            f"the {SENSORS[group]}'s scale or axes are off by a half: that is no calibration",
            remedy="Is it the part that the firmware takes it for? `terazi info` says which.",
        )
    if np.abs(after_counts).max() > OFFSET_MAX_COUNTS:
        raise CalibrationRefused(
            f"the {SENSORS[group]}'s offset of {np.abs(after_counts).max():.0f} counts is more "
            f"than the {OFFSET_MAX_COUNTS} that the device can take off",
            remedy="Move it away from iron and magnets."
            if group == "mag"
            else "The part may be broken: try `terazi calibrate --imu --self-test`.",
        )
    values = [int(d_q16[place]) for place in PLACES[group]]
    values += np.rint(after_counts * 8).astype(int).tolist()
    return dict(zip(setting_names(group), values, strict=True))


def nothing_set(group: str) -> dict[str, int]:
    """Settings of a perfect sensor."""
    return dict.fromkeys(setting_names(group), 0)


def measured(group: str, settings: Mapping[str, int], raw_counts: np.ndarray) -> np.ndarray:
    """(n, 3) int16 that the device makes of raw counts: its own imu_cal.

    settings : by name; others than this group's may be among them.
    """
    d_q16 = [[0, 0, 0] for _row in range(3)]
    *matrix, x, y, z = (settings[name] for name in setting_names(group))
    for (row, column), value in zip(PLACES[group], matrix, strict=True):
        d_q16[row][column] = value
    return ImuCal(d_q16, (x, y, z)).block(raw_counts)
