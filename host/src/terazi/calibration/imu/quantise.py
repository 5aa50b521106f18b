# SPDX-License-Identifier: MIT
"""True constants of a sensor as the device's settings hold them.

true = M (raw - offset) becomes raw + D raw - o with D = M - I in Q16 and o = M offset in Q3
(imu_cal.h).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from terazi.applications.attitude.calibrated import PLACES, setting_names
from terazi.errors import CalibrationRefused
from terazi.link.generated.settings import SETTINGS_BY_NAME

ROW_MAX = 32767  # sum of |D| in Q16, imu_cal.h
OFFSET_MAX_COUNTS = 4095
SENSORS = {"acc": "accelerometer", "gyro": "gyroscope", "mag": "magnetometer"}


@dataclass(frozen=True)
class Constants:
    """What one sensor needs, in its raw counts."""

    matrix: np.ndarray  # (3, 3) M
    offset_counts: np.ndarray  # (3,) on raw axes

    def apply(self, raw) -> np.ndarray:
        """Unrounded, for fits."""
        return (np.asarray(raw, dtype=np.float64) - self.offset_counts) @ self.matrix.T


def settings_of(group: str, constants: Constants) -> dict[str, int]:
    """Settings by name. Raises CalibrationRefused where the device cannot hold them."""
    d_q16 = np.rint((constants.matrix - np.eye(3)) * (1 << 16)).astype(int)
    after_counts = constants.matrix @ constants.offset_counts
    values = [int(d_q16[place]) for place in PLACES[group]]
    bounds = [SETTINGS_BY_NAME[name] for name in setting_names(group)]
    is_held = all(
        bound.minimum <= value <= bound.maximum
        for value, bound in zip(values, bounds, strict=False)
    )
    if not is_held or np.abs(d_q16).sum(axis=1).max() > ROW_MAX:
        most = float(np.abs(constants.matrix - np.eye(3)).max())
        raise CalibrationRefused(
            f"the {SENSORS[group]}'s scale or axes are off by {most:.0%}: more than the device can "
            "put right",
            remedy="Move it away from iron and magnets."
            if group == "mag"
            else "Is it the part that the firmware takes it for? `terazi info` says which.",
        )
    if np.abs(after_counts).max() > OFFSET_MAX_COUNTS:
        raise CalibrationRefused(
            f"the {SENSORS[group]}'s offset of {np.abs(after_counts).max():.0f} counts is more "
            f"than the {OFFSET_MAX_COUNTS} that the device can take off",
            remedy="Move it away from iron and magnets."
            if group == "mag"
            else "The part may be broken: try `terazi calibrate --imu --self-test`.",
        )
    values += np.rint(after_counts * 8).astype(int).tolist()
    return dict(zip(setting_names(group), values, strict=True))
