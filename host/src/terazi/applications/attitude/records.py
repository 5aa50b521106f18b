# SPDX-License-Identifier: MIT
"""What an inertial sensor measured, wherever it was recorded: a capture, or an .npz.

An .npz is one of trials.py's format, of which `gyr` and `acc` are enough here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from terazi import units
from terazi.applications.attitude import trials
from terazi.errors import CannotRead, UsageError
from terazi.recorder import load_recording
from terazi.recorder.inertial import Inertial, counts_of, numbered

GRAVITY_M_S2 = 9.80665


@dataclass(frozen=True)
class Record:
    """n samples on the part's own axes, in the chip's counts (trials.py)."""

    name: str
    rate_hz: float  # of the samples that are here
    number: np.ndarray  # (n,) int64, of each sample by the sensor; a step > `every` is a loss
    every: int  # steps of the number from one sample to the next where none is lost
    gyro_b_counts: np.ndarray  # (n, 3) int16
    acc_b_counts: np.ndarray  # (n, 3) int16
    mag_b_counts: np.ndarray | None = None  # (n, 3) int16
    truth_wb: np.ndarray | None = None  # (n, 4) float64 unit quaternions, NaN where missing
    moving: np.ndarray | None = None  # (n,) bool

    def __len__(self) -> int:
        return len(self.number)

    @property
    def t_s(self) -> np.ndarray:
        """(n,) seconds since the first sample."""
        return (self.number - self.number[0]) / (self.every * self.rate_hz)

    @property
    def rate_b_deg_s(self) -> np.ndarray:
        """(n, 3) turn rates, as measured."""
        return self.gyro_b_counts / trials.GYRO_COUNTS_PER_DEG_S

    @property
    def acc_b_g(self) -> np.ndarray:
        """(n, 3) accelerations in standard gravities, as measured."""
        return self.acc_b_counts / trials.ACC_COUNTS_PER_G

    def between(self, begin_s: float | None, end_s: float | None) -> Record:
        """The samples of a stretch of time. UsageError where there is none."""
        t_s = self.t_s
        first = 0 if begin_s is None else int(np.searchsorted(t_s, begin_s))
        last = len(self) if end_s is None else int(np.searchsorted(t_s, end_s))
        if last - first < 2:
            raise UsageError(
                f"nothing of {self.name} lies there: it lasts from 0 to {t_s[-1]:.1f} s"
            )
        return self.part(first, last)

    def part(self, first: int, last: int) -> Record:
        """Samples [first, last)."""
        arrays = ("number", "gyro_b_counts", "acc_b_counts", "mag_b_counts", "truth_wb", "moving")
        columns = {name: getattr(self, name) for name in arrays}
        kept = {name: each[first:last] for name, each in columns.items() if each is not None}
        return replace(self, **kept)

    def whole_stretches(self) -> list[tuple[int, int]]:
        """Samples [first, last) between which none is missing."""
        cuts = np.flatnonzero(np.diff(self.number) != self.every) + 1
        edges = [0, *cuts.tolist(), len(self)]
        return list(pairwise(edges))


def load_npz(path: Path) -> Record:
    """An .npz; what else than gyr and acc it holds is taken along. Raises CannotRead."""
    fields = trials.read_fields(path, needed=("gyr", "acc"))
    count = len(fields["gyr"])
    rate_hz = trials.rate_of(path, fields)
    mag, quat, movement = (fields.get(name) for name in ("mag", "quat", "movement"))
    if count < 2:
        raise CannotRead(f"{path}: holds {count} samples")
    return Record(
        name=path.stem,
        rate_hz=rate_hz,
        number=np.arange(count),
        every=1,
        gyro_b_counts=trials.chip_counts(path, fields, "gyr"),
        acc_b_counts=trials.chip_counts(path, fields, "acc"),
        mag_b_counts=None if mag is None else trials.chip_counts(path, fields, "mag"),
        truth_wb=None if quat is None else trials.unit_quaternions(quat),
        moving=None if movement is None else movement == 1,
    )


def of_inertial(inertial: Inertial, name: str) -> Record:
    """The IMU messages of the longest run of the device. Raises CannotRead."""
    imu, mag = inertial.imu, inertial.mag
    if not len(imu["order"]):
        raise CannotRead(
            f"{name} holds no IMU messages",
            remedy="Record them with terazi log --imu.",
        )
    boots, counts = np.unique(imu["boot"], return_counts=True)
    run = boots[np.argmax(counts)]
    imu = {key: column[imu["boot"] == run] for key, column in imu.items()}
    mag = {key: column[mag["boot"] == run] for key, column in mag.items()}
    number = numbered(imu["sample"], imu["device_us"])
    if len(number) < 2 or number[-1] == number[0]:
        raise CannotRead(f"{name} holds {len(number)} IMU messages")
    every = int(np.median(np.diff(number)))
    device_us = imu["device_us"]
    rate_hz = (number[-1] - number[0]) / (device_us[-1] - device_us[0]) * units.US_PER_S
    return Record(
        name=name,
        rate_hz=float(rate_hz) / every,
        number=number,
        every=every,
        gyro_b_counts=counts_of(imu, "gyro_"),
        acc_b_counts=counts_of(imu, "acc_"),
        mag_b_counts=_newest(mag, imu),
    )


def _newest(mag: dict[str, np.ndarray], imu: dict[str, np.ndarray]) -> np.ndarray | None:
    """The field that each sample was used with; before the first, the first. None: there is none.

    A MAG comes before the IMU message whose sample it was first used with.
    """
    if not len(mag["order"]):
        return None
    at = np.searchsorted(mag["order"], imu["order"], side="right") - 1
    return counts_of(mag)[np.maximum(at, 0)]


def load_record(path: Path) -> Record:
    """A capture or an .npz, told apart by the name's end."""
    if path.suffix == ".npz":
        return load_npz(path)
    return of_inertial(load_recording(path, needs_samples=False).inertial, path.name)
