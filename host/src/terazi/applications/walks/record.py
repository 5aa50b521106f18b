# SPDX-License-Identifier: MIT
"""What a walk is: an inertial sensor on a foot, in SI units, and what is known of the path."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from terazi.applications.walks.clipping import Rates, unclipped


@dataclass(frozen=True)
class Truth:
    """Where the foot really was, in axes of its own: z up, right-handed, heading free.

    at : (k,) samples at which it is known.  pos_t_m : (k, 2) or (k, 3).
    from_start : the origin is the first point, which alone is matched; else the mean of all is.
    """

    at: np.ndarray
    pos_t_m: np.ndarray
    from_start: bool = False

    @property
    def returns(self) -> bool:
        """It ends where it began, within half a metre."""
        return bool(np.linalg.norm(self.pos_t_m[-1] - self.pos_t_m[0]) < RETURNS_M)


@dataclass(frozen=True)
class Device:
    """What the recording device itself said of zero velocity.

    detector : of the device, by its setting's word.  still : (n,) bool; None where it said nothing,
    `why` not.  late_s : so long after the middle of what it judged it says so.
    """

    detector: str
    still: np.ndarray | None
    late_s: float = 0.0
    why: str = ""


RETURNS_M = 0.5
RATE_S = 2.0
CLOCK = 0.005


@dataclass(frozen=True)
class Walk:
    """One record. Specific force at rest points up: body axes are free."""

    name: str
    t_s: np.ndarray  # (n,) strictly growing
    acc_b_m_s2: np.ndarray  # (n, 3)
    gyro_b_rad_s: np.ndarray  # (n, 3)
    truth: Truth | None = None
    zero_velocity: np.ndarray | None = None  # (n,) bool: known labels
    mag_b: np.ndarray | None = None  # (n, 3), any unit
    notes: tuple[str, ...] = field(default=())
    device: Device | None = None  # where the product itself recorded

    def __len__(self) -> int:
        return len(self.t_s)

    @property
    def rate_hz(self) -> float:
        """Of the first seconds, so that it does not depend on how long the record is; a rate that
        misses a whole number of Hz by no more than a clock does is that number."""
        last = min(int(np.searchsorted(self.t_s, self.t_s[0] + RATE_S)), len(self) - 1)
        found = last / float(self.t_s[last] - self.t_s[0])
        return float(round(found)) if abs(found - round(found)) < CLOCK * found else found

    @property
    def dt_s(self) -> np.ndarray:
        """(n,) s since the sample before; the first lasts as long as the usual one."""
        steps = np.diff(self.t_s)
        return np.concatenate([[1 / self.rate_hz], steps])

    @cached_property
    def rates(self) -> Rates:
        """Angular rates for a navigator: what the gyroscope's range cut off is put back."""
        return unclipped(self.gyro_b_rad_s, self.rate_hz)

    @property
    def may_return(self) -> bool:
        """Its closure says something: the truth returns, or nobody knows better."""
        return self.truth is None or self.truth.returns

    def cut(self, count: int) -> Walk:
        """The first `count` samples."""
        truth = self.truth
        if truth is not None:
            kept = truth.at < count
            truth = Truth(truth.at[kept], truth.pos_t_m[kept], truth.from_start)
            truth = truth if kept.sum() > 1 else None
        arrays = {
            name: None if value is None else value[:count]
            for name, value in (
                *(("t_s", self.t_s), ("acc_b_m_s2", self.acc_b_m_s2)),
                *(("gyro_b_rad_s", self.gyro_b_rad_s), ("mag_b", self.mag_b)),
                ("zero_velocity", self.zero_velocity),
            )
        }
        device = self.device
        if device is not None and device.still is not None:
            device = replace(device, still=device.still[:count])
        return replace(self, truth=truth, device=device, **arrays)
