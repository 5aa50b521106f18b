# SPDX-License-Identifier: MIT
"""Raw counts as the device measures them by its settings: its own imu_cal.

true = raw + D raw - o, with D in Q16 and o in Q3 (imu_cal.h). An accelerometer's D is a lower
triangle: which way a board is turned, gravity's length does not tell.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from terazi.cshared import ImuCal
from terazi.link.generated.messages import Setting
from terazi.link.generated.settings import SETTINGS
from terazi.recorder.inertial import Inertial

AXES = "xyz"
LOWER = tuple((row, column) for row in range(3) for column in range(row + 1))
SQUARE = tuple((row, column) for row in range(3) for column in range(3))
PLACES = {"acc": LOWER, "gyro": SQUARE, "mag": SQUARE}  # of the matrix, in the order of its keys
ORIENTATIONS = ("imu.orientation", "mag.orientation")
NAMES = {setting.key: setting.full_name for setting in SETTINGS}


def setting_names(group: str) -> list[str]:
    """Of matrix, then offset, by the order of their keys."""
    matrix = [f"{group}.{AXES[row]}{AXES[column]}_q16" for row, column in PLACES[group]]
    return matrix + [f"{group}.offset_q3_{at}" for at in range(3)]


def nothing_set(group: str) -> dict[str, int]:
    """Settings of a perfect sensor."""
    return dict.fromkeys(setting_names(group), 0)


def measured(group: str, settings: Mapping[str, int], raw_counts: np.ndarray) -> np.ndarray:
    """(n, 3) int16 that the device makes of raw counts, along the part's own axes.

    settings : by name; others than this group's may be among them.
    """
    d_q16 = [[0, 0, 0] for _row in range(3)]
    *matrix, x, y, z = (settings[name] for name in setting_names(group))
    for (row, column), value in zip(PLACES[group], matrix, strict=True):
        d_q16[row][column] = value
    return ImuCal(d_q16, (x, y, z)).block(raw_counts)


def told_settings(inertial: Inertial) -> dict[str, int] | None:
    """Settings by name as a capture tells them first; None where it does not tell all of these."""
    values: dict[str, int] = {}
    for _order, one in inertial.told:
        if isinstance(one.message, Setting) and one.message.key in NAMES:
            values.setdefault(NAMES[one.message.key], one.message.value)
    needed = {*ORIENTATIONS, *(name for group in PLACES for name in setting_names(group))}
    return values if needed <= set(values) else None
