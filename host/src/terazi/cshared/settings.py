# SPDX-License-Identifier: MIT
"""settings of shared_c: values by key, and records of them byte by byte."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple, Self

from terazi.cshared._cshared import ffi, lib

SettingsStatus = IntEnum(
    "SettingsStatus",
    {
        name: getattr(lib, f"SETTINGS_{name}")
        for name in ("OK", "UNKNOWN_KEY", "OUT_OF_RANGE", "WRITE_PROTECTED")
    },
)
SettingsReading = IntEnum(
    "SettingsReading",
    {
        name: getattr(lib, f"SETTINGS_{name}")
        for name in ("READING", "NO_RECORD", "ROTTEN", "FOREIGN", "WHOLE")
    },
)

SettingsCell = IntEnum(
    "SettingsCell",
    {
        name: getattr(lib, f"SETTINGS_CELL_{name}")
        for name in ("REPLACE", "ERASE", "PROGRAM", "PASSED")
    },
)
"""What to do with a cell."""


class SettingsChoice(NamedTuple):
    """settings_choice_t."""

    reading: int
    slot: int
    rotten: int
    sequence: int


class Settings:
    """settings_t (settings.h), as it leaves the factory."""

    def __init__(self) -> None:
        self._c = ffi.new("settings_t *")
        self.reset(calibration=True)

    def reset(self, *, calibration: bool) -> None:
        lib.settings_reset(self._c, calibration)

    def get(self, key: int) -> int | None:
        """The value; None for an unknown key."""
        value = ffi.new("int32_t *")
        status = lib.settings_get(self._c, key, value)
        return None if status == lib.SETTINGS_UNKNOWN_KEY else value[0]

    def set(self, key: int, value: int) -> SettingsStatus:
        return SettingsStatus(lib.settings_set(self._c, key, value))

    @property
    def values(self) -> list[int]:
        """By key."""
        return [self.get(key) for key in range(lib.SETTINGS_KEYS)]

    def record(self, sequence: int) -> bytes:
        """The record of these settings."""
        state = ffi.new("settings_record_t *")
        lib.settings_record_begin(state, sequence)
        return bytes(
            lib.settings_record_next(state, self._c) for _ in range(lib.SETTINGS_RECORD_LEN)
        )

    def read(self, slot: bytes) -> tuple[SettingsReading, int]:
        """Take the values of a slot's record if it is whole; gives reading and sequence."""
        reading, state = _read(slot, ffi.NULL)
        if reading == lib.SETTINGS_WHOLE:
            _read(slot, self._c)
        return SettingsReading(reading), lib.settings_record_sequence(state)

    def copy(self) -> Self:
        """Another one with the same values."""
        twin = object.__new__(type(self))
        twin._c = ffi.new("settings_t *", self._c[0])
        return twin


class SettingsSave:
    """Saves settings, cell by cell (settings.h). The cells are the caller's.

    slots : what they hold before, by which the newest record is known.
    """

    def __init__(self, slots: Sequence[bytes]) -> None:
        self._c = ffi.new("settings_save_t *")
        lib.settings_save_begin(self._c, _choose(slots))

    @property
    def state(self) -> int:
        """0 idle, 1 writing, 2 failed."""
        return self._c.state

    @property
    def sequence(self) -> int:
        """Of the newest record; 0: there is none."""
        return self._c.newest.sequence

    @property
    def address(self) -> int:
        """The cell that comes next, while writing."""
        return lib.settings_save_address(self._c)

    def ask(self) -> None:
        """Save, from now on or anew."""
        lib.settings_save_ask(self._c)

    def step(self, settings: Settings, cell: int) -> tuple[SettingsCell, int]:
        """What to do with that cell, and what it must hold."""
        step = lib.settings_save_step(self._c, settings._c, cell)
        return SettingsCell(step), self._c.wanted


def _read(slot: bytes, settings) -> tuple[int, object]:
    state = ffi.new("settings_record_t *")
    lib.settings_record_begin(state, 0)
    reading = lib.SETTINGS_READING
    for byte in slot:
        if reading != lib.SETTINGS_READING:
            break
        reading = lib.settings_record_read(state, settings, byte)
    return reading, state


def _choose(slots: Sequence[bytes]):
    choice = ffi.new("settings_choice_t *")
    lib.settings_choice_begin(choice)
    for at, slot in enumerate(slots):
        reading, state = _read(slot, ffi.NULL)
        lib.settings_choose(choice, at, state, reading)
    return choice


def choose_settings(slots: Sequence[bytes]) -> SettingsChoice:
    """The newest record among slots."""
    choice = _choose(slots)
    return SettingsChoice(choice.reading, choice.slot, choice.rotten, choice.sequence)
