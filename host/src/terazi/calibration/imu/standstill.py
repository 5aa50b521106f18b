# SPDX-License-Identifier: MIT
"""Finds when a board lies still among the samples of its IMU, live or in a recording.

Blocks of BLOCK_S are quiet where neither sensor shakes; quiet blocks in a row that also agree in
their means are a standstill. Its first block and its last are left out: hands are still near.
A hand that holds the board is never so still.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from terazi.units import ACC_COUNTS_PER_STANDARD_GRAVITY as ACC_COUNTS
from terazi.units import GYRO_COUNTS_PER_DEG_S as GYRO_COUNTS

BLOCK_S = 0.25
STILL_S = 2.5  # until a standstill counts; 2 s of it are used
LONGEST_S = 10.0  # of it is used
QUIET_G, QUIET_DEG_S = 0.020, 0.5  # rms within a block; the part's own noise is 5 mg, 0.06 deg/s
AGREE_G, AGREE_DEG_S = 0.008, 0.3  # of blocks' means


@dataclass(frozen=True)
class Standstill:
    """Means in counts of samples [first, last); it lay still until `end`."""

    first: int
    last: int
    end: int
    acc_counts: np.ndarray  # (3,)
    gyro_counts: np.ndarray  # (3,)

    @property
    def up(self) -> np.ndarray:
        """(3,) unit vector that the accelerometer feels, as measured."""
        return self.acc_counts / np.linalg.norm(self.acc_counts)


class Finder:
    """Takes samples in pieces of any length; `found` grows."""

    def __init__(self, rate_hz: float) -> None:
        self._size = max(4, round(BLOCK_S * rate_hz))
        self._needed = round(STILL_S / BLOCK_S)
        self._most = round(LONGEST_S / BLOCK_S)
        self._waiting = np.empty((0, 6))
        self._blocks: list[np.ndarray] = []  # means of the present run, [acc, gyro]
        self._end = 0  # samples in whole blocks so far
        self.found: list[Standstill] = []
        self.is_quiet = False  # the latest block
        self.latest = np.zeros(6)  # its means
        self.shake_g = self.shake_deg_s = 0.0

    @property
    def still_s(self) -> float:
        """For how long it has lain still by now."""
        return len(self._blocks) * BLOCK_S

    def feed(self, acc_counts: np.ndarray, gyro_counts: np.ndarray) -> bool:
        """Take (n, 3) each; whether a new standstill was found."""
        before = len(self.found)
        rows = np.column_stack([acc_counts, gyro_counts]).astype(np.float64)
        self._waiting = np.vstack([self._waiting, rows])
        whole = len(self._waiting) // self._size * self._size
        for at in range(0, whole, self._size):
            self._take(self._waiting[at : at + self._size])
        self._waiting = self._waiting[whole:]
        return len(self.found) > before

    def _take(self, block: np.ndarray) -> None:
        self._end += self._size
        spread = block.std(axis=0)
        self.latest = block.mean(axis=0)
        self.shake_g = float(spread[:3].max() / ACC_COUNTS)
        self.shake_deg_s = float(spread[3:].max() / GYRO_COUNTS)
        self.is_quiet = self.shake_g < QUIET_G and self.shake_deg_s < QUIET_DEG_S
        if not self.is_quiet or not self._agrees(self.latest):
            self._blocks = []
        if self.is_quiet:
            self._blocks.append(self.latest)
        if len(self._blocks) >= self._needed:
            self._note()

    def _agrees(self, means: np.ndarray) -> bool:
        if not self._blocks:
            return True
        away = np.abs(means - np.mean(self._blocks, axis=0))
        acc, gyro = away[:3].max() / ACC_COUNTS, away[3:].max() / GYRO_COUNTS
        return bool(acc < AGREE_G and gyro < AGREE_DEG_S)

    def _note(self) -> None:
        """The present run as a standstill, in place of its shorter self."""
        first = self._end - (len(self._blocks) - 1) * self._size
        last = self._end - self._size
        is_known = bool(self.found) and self.found[-1].first == first
        if len(self._blocks) > self._most:
            if is_known:
                self.found[-1] = replace(self.found[-1], end=last)
            return
        means = np.mean(self._blocks[1:-1], axis=0)
        one = Standstill(first, last, last, means[:3], means[3:])
        self.found[len(self.found) - is_known :] = [one]


def find(acc_counts: np.ndarray, gyro_counts: np.ndarray, rate_hz: float) -> list[Standstill]:
    """All standstills of (n, 3) samples."""
    finder = Finder(rate_hz)
    finder.feed(acc_counts, gyro_counts)
    return finder.found
