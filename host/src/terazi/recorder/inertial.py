# SPDX-License-Identifier: MIT
"""ATTITUDE, IMU and MAG as columns: hundreds a second, so that no object is kept for each.

In memory the columns are the message's own fields, beside host_s, device_us and boot as in
columns.py, `order`, the place of the message among all that came, and `lost`, how many frames were
missing up to there. In tables the fields are in units that people read.
"""

import dataclasses
from array import array
from dataclasses import dataclass, field

import numpy as np

from terazi import rotation, units
from terazi.link.generated.messages import Attitude, AttitudeFlag, Imu, Mag
from terazi.link.stream import Received

KINDS = (Attitude, Imu, Mag)
HEAD = {"host_s": "d", "device_us": "q", "boot": "i", "order": "q", "lost": "q"}
# What messages.toml gives these fields; every other one fits in 32 bits with its sign.
CODES = {"sample": "H", "flags": "B"}


class MessageColumns:
    """Grows by messages of one kind; gives numpy arrays."""

    def __init__(self, kind: type) -> None:
        self._names = [one.name for one in dataclasses.fields(kind)]
        codes = HEAD | {name: CODES.get(name, "i") for name in self._names}
        self._arrays = {name: array(code) for name, code in codes.items()}

    def __len__(self) -> int:
        return len(self._arrays["host_s"])

    def append(self, received: Received, order: int = 0, lost: int = 0) -> None:
        message = received.message
        row = [received.host_s, received.device_us, received.boot, order, lost]
        row += [int(getattr(message, name)) for name in self._names]
        for column, value in zip(self._arrays.values(), row, strict=True):
            column.append(value)

    def to_numpy(self) -> dict[str, np.ndarray]:
        return {name: np.array(column) for name, column in self._arrays.items()}


@dataclass
class Inertial:
    """All that a recording tells of the IMU, each kind as columns; empty where none came.

    told : everything else but samples, with its place among all that came.
    """

    attitude: dict[str, np.ndarray]
    imu: dict[str, np.ndarray]
    mag: dict[str, np.ndarray]
    told: list[tuple[int, Received]] = field(default_factory=list)

    def __len__(self) -> int:
        return sum(len(columns["order"]) for columns in (self.attitude, self.imu, self.mag))


class InertialColumns:
    """Takes messages as they come."""

    def __init__(self) -> None:
        self._columns = {kind: MessageColumns(kind) for kind in KINDS}
        self._told: list[tuple[int, Received]] = []
        self._order = self._lost = 0

    def take(self, received: Received) -> bool:
        """Whether it was one of KINDS, and is kept here."""
        self._lost += received.lost_before
        columns = self._columns.get(type(received.message))
        if columns is not None:
            columns.append(received, self._order, self._lost)
        self._order += 1
        return columns is not None

    def tell(self, received: Received) -> None:
        """Note the place of what take did not keep."""
        self._told.append((self._order - 1, received))

    def to_inertial(self) -> Inertial:
        attitude, imu, mag = (self._columns[kind].to_numpy() for kind in KINDS)
        return Inertial(attitude, imu, mag, self._told)


# --- tables ---


def table_of_kind(kind: type, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The columns that CSV and Parquet show, in their order."""
    head = {
        "host_s": columns["host_s"],
        "device_s": units.s_from_us(columns["device_us"]),
        "boot": columns["boot"],
        "sample": columns["sample"],
    }
    return head | {Attitude: _attitude, Imu: _imu, Mag: _mag}[kind](columns)


def _attitude(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    quat_wb = quats_of(columns)
    angles = rotation.euler_deg(quat_wb)
    table = {f"quat_{axis}": quat_wb[:, at] for at, axis in enumerate("wxyz")}
    table |= {f"{name}_deg": angles[:, at] for at, name in enumerate(("roll", "pitch", "yaw"))}
    for flag in AttitudeFlag:
        table[flag.name.lower()] = (columns["flags"] & int(flag) != 0).astype(np.uint8)
    return table


def _imu(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    table = {
        f"acc_{axis}_m_s2": units.m_s2_from_counts(columns[f"acc_{axis}_counts"]) for axis in "xyz"
    }
    for axis in "xyz":
        table[f"gyro_{axis}_deg_s"] = units.deg_s_from_counts(columns[f"gyro_{axis}_counts"])
    table["temperature_deg_c"] = units.deg_c_from_counts(columns["temp_counts"])
    raw = [name for name in columns if name.endswith("_counts")]
    return table | {name: columns[name].astype(np.int16) for name in raw}


def _mag(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {f"{axis}_counts": columns[f"{axis}_counts"].astype(np.int16) for axis in "xyz"}


def quats_of(columns: dict[str, np.ndarray]) -> np.ndarray:
    """(n, 4) float64 of ATTITUDE's columns: body to world, scalar first, as they were sent."""
    quats_q30 = np.stack([columns[f"quat_{axis}_q30"] for axis in "wxyz"], axis=1)
    return units.one_from_q30(quats_q30)


def counts_of(columns: dict[str, np.ndarray], prefix: str = "") -> np.ndarray:
    """(n, 3) int16 of IMU's or MAG's columns; prefix: acc_ or gyro_, or none for MAG."""
    vectors = [columns[f"{prefix}{axis}_counts"] for axis in "xyz"]
    return np.stack(vectors, axis=1).astype(np.int16)


def numbered(sample: np.ndarray, device_us: np.ndarray) -> np.ndarray:
    """Numbers of 16 bits that wrap as a count that rises, by the clock where they do not tell.

    A part that was away counts nothing meanwhile; one whose settings change counts anew.
    """
    steps = np.diff(sample.astype(np.int64)) % (1 << 16)
    passed_us = np.diff(device_us).astype(np.float64)
    if not len(steps) or not steps.any():
        return np.zeros(len(sample), np.int64)
    period_us = np.median(passed_us[steps > 0] / steps[steps > 0])
    by_clock = passed_us / max(period_us, 1.0)
    is_told = np.abs(steps - by_clock) < 1 + 0.05 * by_clock
    steps = np.where(is_told, steps, np.maximum(np.rint(by_clock), 1)).astype(np.int64)
    return np.concatenate([[0], np.cumsum(steps)])
