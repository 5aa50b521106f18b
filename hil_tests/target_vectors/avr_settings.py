# SPDX-License-Identifier: MIT
"""settings as they run on the chip, with store and EEPROM driver; see ``runner_settings.c``."""

from __future__ import annotations

import struct

from target_vectors.avr_core import START_UP_S, AvrCore

SAVE_TIMEOUT_S = 2.0  # a first save takes 0.65 s
STEP_S = 50e-6
EEAR = 0x41


class SettingsChip(AvrCore):
    """A chip whose EEPROM can be looked at, and whose power can be cut."""

    @property
    def eeprom(self) -> bytes:
        return self._uno.eeprom.get()

    @eeprom.setter
    def eeprom(self, cells: bytes) -> None:
        self._uno.eeprom.set(0, cells)

    def load(self) -> tuple[int, int]:
        """What the start of the firmware does: reading and sequence."""
        return struct.unpack("<BH", self.request("l"))

    def get(self, key: int) -> tuple[int, int]:
        """Status and value."""
        return struct.unpack("<Bi", self.request("g", bytes([key])))

    def values(self, keys: int) -> list[int]:
        """Of the first so many keys."""
        return [self.get(key)[1] for key in range(keys)]

    def set(self, key: int, value: int) -> int:
        """Status."""
        return self.request("s", struct.pack("<Bi", key, value))[0]

    def reset(self, *, calibration: bool) -> None:
        self.request("r", bytes([calibration]))

    def record(self, sequence: int) -> bytes:
        """The record of the settings there are."""
        return self.request("p", struct.pack("<H", sequence))

    def save(self) -> tuple[int, int]:
        """State and sequence after a whole save."""
        return struct.unpack("<BH", self.request("S"))

    @property
    def writes(self) -> int:
        """Of EEPROM cells, begun since the board was made."""
        return self._uno.stats["eeprom_writes"]

    def begin_save(self) -> None:
        """Ask for a save; into_write lets it go on."""
        self._uno.uart.read()
        self._uno.uart.write(b"S\0")

    def into_write(self, count: int = 1) -> bool:
        """Let a save go on into the write of so many cells further; False: it ended before."""
        wanted, uno = self.writes + count, self._uno
        uno.run_until(
            lambda: self.writes >= wanted or uno.uart.available, SAVE_TIMEOUT_S, step_s=STEP_S
        )
        if self.writes >= wanted:
            return True
        uno.run(START_UP_S)  # the whole reply
        uno.uart.read()
        return False

    @property
    def cell_in_work(self) -> int:
        """Address of the cell that is being written (EEAR)."""
        return int.from_bytes(self._uno.peek(EEAR, 2), "little")

    def poke(self, settings: bytes) -> None:
        """Put settings into memory as they lie there."""
        self._uno.poke(self._uno.symbol("settings"), settings)

    def peek(self, size: int) -> bytes:
        """What poke would put there."""
        return self._uno.peek(self._uno.symbol("settings"), size)

    def cut_power(self) -> None:
        """At once; and then on again."""
        self._uno.reset("power_on")
        self._uno.run(START_UP_S)
        self._uno.uart.read()
