# SPDX-License-Identifier: MIT
"""Which way the magnetometer sits beside the IMU: the field dips alike in every position.

Maps of modules are often wrong or missing; a board that turned a field's axes would have a heading
that jumps as it tilts. Of the 24 ways to sit the right one gives one angle between field and
vertical, wherever the board looks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from terazi.cshared import ImuTurn
from terazi.link.generated.settings import SETTINGS_BY_NAME

NAMES = {code: name for name, code in SETTINGS_BY_NAME["mag.orientation"].choices}
POSITIONS_LEAST = 6
WRONG_TIMES = 3.0  # the present one spreads the dip so many times as far as the best
ALONE_TIMES = 2.0  # and the second best twice as far
SPREAD_MOST_DEG = 5.0


@dataclass(frozen=True)
class MagAxes:
    """How the magnetometer sits, and what speaks for it: rms of the dip over the positions."""

    best: int
    present: int
    best_deg: float
    present_deg: float
    second_deg: float

    @property
    def is_known(self) -> bool:
        """One way to sit goes with the positions, and no other."""
        return self.best_deg < SPREAD_MOST_DEG and self.second_deg > ALONE_TIMES * self.best_deg

    @property
    def is_wrong(self) -> bool:
        """The present one is not it."""
        return (
            self.is_known
            and self.present != self.best
            and self.present_deg > WRONG_TIMES * self.best_deg
        )

    @property
    def note(self) -> str:
        """For people; "" where there is nothing to say."""
        if self.is_wrong:
            return (
                f"the magnetometer sits as {NAMES[self.best]}, not as {NAMES[self.present]}: so the"
                f" field dips alike within {self.best_deg:.1f} deg in every position, before "
                f"within {self.present_deg:.0f} deg"
            )
        if not self.is_known:
            return (
                "how the magnetometer sits does not show: the field's dip spreads by "
                f"{self.best_deg:.1f} deg at best; was there iron about?"
            )
        return ""


def find_mag_axes(
    ups: Sequence[np.ndarray], fields: Sequence[np.ndarray], imu_code: int, mag_code: int
) -> MagAxes | None:
    """ups, fields : of each position, calibrated, along the parts' own axes.

    imu_code, mag_code : settings imu.orientation and mag.orientation. None: too few positions.
    """
    if len(ups) < POSITIONS_LEAST:
        return None
    up_b = np.array(ups) @ turn_of(imu_code).T
    fields = np.array(fields)
    fields = fields / np.linalg.norm(fields, axis=1)[:, None]
    spreads = {}
    for code in NAMES:
        sines = np.clip(np.sum(up_b * (fields @ turn_of(code).T), axis=1), -1.0, 1.0)
        spreads[code] = float(np.degrees(np.arcsin(sines)).std())
    best, second, *_rest = sorted(spreads, key=spreads.get)
    return MagAxes(best, mag_code, spreads[best], spreads.get(mag_code, 90.0), spreads[second])


def turn_of(code: int) -> np.ndarray:
    """(3, 3): the board's axes of a vector along the part's."""
    return ImuTurn(code).block(np.eye(3, dtype=np.int16)).T.astype(np.float64)
