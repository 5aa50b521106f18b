# SPDX-License-Identifier: MIT
"""Twin of settings.h, straight from its contract: values by key, records, and which one counts.

There is nothing to model in floating point. What keys there are is handed in, as a row of Entry.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

SLOTS, SLOT_LEN = 4, 256
MAGIC, ERASED, VERSION = 0x54, 0xFF, 1
HEAD_LEN, CRC_LEN = 5, 2
IMU_CALIBRATIONS = ("acc", "gyro", "mag")  # groups
Status = IntEnum("Status", "OK UNKNOWN_KEY OUT_OF_RANGE WRITE_PROTECTED", start=0)
Reading = IntEnum("Reading", "READING NO_RECORD ROTTEN FOREIGN WHOLE", start=0)


@dataclass(frozen=True)
class Entry:
    """One key; the row's index is its number."""

    type: str  # u8 i8 u16 i16 u32 i32
    minimum: int
    maximum: int
    factory: int
    is_protected: bool
    is_spared: bool = False  # by a reset that keeps the calibration, as what is protected

    @classmethod
    def of(cls, one) -> Entry:
        """Of a setting of the spec or of its generated table."""
        is_imu_calibration = one.group in IMU_CALIBRATIONS and not one.choices
        limits = (one.minimum, one.maximum, one.default)
        return cls(one.type, *limits, bool(one.by), is_imu_calibration)

    @property
    def width(self) -> int:
        return int(self.type[1:]) // 8


def crc16(data: bytes) -> int:
    """CRC-16/MCRF4XX by its definition."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x8408 if crc & 1 else 0)
    return crc


def factory(entries: Sequence[Entry]) -> list[int]:
    """Values as they leave the factory."""
    return [entry.factory for entry in entries]


def put(entries: Sequence[Entry], values: list[int], key: int, value: int) -> Status:
    """settings_set; values change in place."""
    if key >= len(entries):
        return Status.UNKNOWN_KEY
    entry = entries[key]
    if entry.is_protected:
        return Status.WRITE_PROTECTED
    if not entry.minimum <= value <= entry.maximum:
        return Status.OUT_OF_RANGE
    values[key] = value
    return Status.OK


def reset(entries: Sequence[Entry], values: list[int], calibration: bool) -> None:
    """settings_reset; values change in place."""
    for key, entry in enumerate(entries):
        if calibration or not (entry.is_protected or entry.is_spared):
            values[key] = entry.factory


def payload(entries: Sequence[Entry], values: Sequence[int]) -> bytes:
    """Values in the order of keys."""
    return b"".join(
        value.to_bytes(entry.width, "little", signed=entry.type[0] == "i")
        for entry, value in zip(entries, values, strict=True)
    )


def frame(body: bytes, sequence: int, version: int = VERSION) -> bytes:
    """A record of any payload."""
    covered = bytes([version, len(body)]) + sequence.to_bytes(2, "little") + body
    return bytes([MAGIC]) + covered + crc16(covered).to_bytes(2, "little")


def record(entries: Sequence[Entry], values: Sequence[int], sequence: int) -> bytes:
    """The record of these values."""
    return frame(payload(entries, values), sequence)


def read(entries: Sequence[Entry], slot: bytes) -> tuple[Reading, int, list[int] | None]:
    """What a slot of 256 bytes holds: reading, sequence, and of a whole record the values, those
    that it has not at the factory's. Every firmware's record ends with a whole value."""
    if slot[0] != MAGIC:
        return Reading.NO_RECORD, 0, None
    version, length = slot[1], slot[2]
    sequence = int.from_bytes(slot[3:5], "little")
    end = HEAD_LEN + length
    if end + CRC_LEN > SLOT_LEN:
        return Reading.ROTTEN, 0, None
    if crc16(slot[1:end]) != int.from_bytes(slot[end : end + CRC_LEN], "little"):
        return Reading.ROTTEN, 0, None
    if version != VERSION or length > sum(entry.width for entry in entries):
        return Reading.FOREIGN, sequence, None
    values, at = factory(entries), HEAD_LEN
    for key, entry in enumerate(entries):
        if at + entry.width > end:
            break
        part = slot[at : at + entry.width]
        values[key] = int.from_bytes(part, "little", signed=entry.type[0] == "i")
        at += entry.width
    return Reading.WHOLE, sequence, values


@dataclass
class Choice:
    """The newest record among the slots."""

    reading: Reading = Reading.NO_RECORD
    slot: int = SLOTS - 1
    rotten: int = 0
    sequence: int = 0


def choose(readings: Sequence[tuple[Reading, int]]) -> Choice:
    """Readings and sequences of the slots in order; records count modulo 2^16."""
    choice = Choice()
    for slot, (reading, sequence) in enumerate(readings):
        choice.rotten += reading == Reading.ROTTEN
        if reading not in (Reading.FOREIGN, Reading.WHOLE):
            continue
        is_newer = (sequence - choice.sequence) % (1 << 16) < 1 << 15
        if choice.reading == Reading.NO_RECORD or is_newer:
            choice.reading, choice.slot, choice.sequence = reading, slot, sequence
    return choice
