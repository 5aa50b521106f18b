# SPDX-License-Identifier: MIT
"""An EEPROM of bytes whose power may fail at any write, and whose cells may be worn out."""

from __future__ import annotations

from collections.abc import Callable

from terazi.cshared.settings import Settings, SettingsCell, SettingsSave, choose_settings
from terazi.models import settings as twin

SIZE = twin.SLOTS * twin.SLOT_LEN
IDLE, WRITING, FAILED = range(3)
STEPS_MAX = 200_000


class PowerCut(Exception):
    """In the middle of a write."""


class Eeprom:
    """1 KiB of cells.

    wears : number of times that each cell was erased, the larger part of its wear.
    stuck : cells that hold what they hold.
    """

    def __init__(self, cells: bytes = b"\xff" * SIZE) -> None:
        self.cells = bytearray(cells)
        self.wears = [0] * SIZE
        self.stuck: dict[int, int] = {}
        self.writes: list[tuple[int, int, SettingsCell]] = []

    @property
    def slots(self) -> list[bytes]:
        return [bytes(self.cells[at : at + twin.SLOT_LEN]) for at in range(0, SIZE, twin.SLOT_LEN)]

    def read(self, address: int) -> int:
        return self.stuck.get(address, self.cells[address])

    def write(self, address: int, value: int, how: SettingsCell) -> None:
        self.writes.append((address, value, how))
        self.wears[address] += how != SettingsCell.PROGRAM
        if how == SettingsCell.ERASE:
            value = twin.ERASED
        elif how == SettingsCell.PROGRAM:
            value &= self.cells[address]
        self.cells[address] = value

    def load(self) -> tuple[int, Settings]:
        """As store.c does at the start: what the newest record is, and the settings that hold."""
        settings, choice = Settings(), choose_settings(self.slots)
        if choice.reading == twin.Reading.WHOLE:
            settings.read(self.slots[choice.slot])
        return choice.reading, settings


def save(
    eeprom: Eeprom,
    settings: Settings,
    *,
    cut_at: int | None = None,
    left: int = twin.ERASED,
    meanwhile: Callable[[int, SettingsSave, Settings], None] | None = None,
) -> SettingsSave:
    """Save as store.c does; what was saved at last is in the EEPROM, the sequence in what is given.

    cut_at : the power fails in this write, 0 being the first; the cell is left with `left` in it.
    meanwhile : called after each step with its number, the save and the settings.
    """
    saving = SettingsSave(eeprom.slots)
    saving.ask()
    written = 0
    for number in range(STEPS_MAX):
        if saving.state != WRITING:
            return saving
        address = saving.address
        step, wanted = saving.step(settings, eeprom.read(address))
        if step != SettingsCell.PASSED:
            eeprom.write(address, wanted, step)
            if written == cut_at:
                eeprom.cells[address] = left
                raise PowerCut
            written += 1
        if meanwhile:
            meanwhile(number, saving, settings)
    raise AssertionError("a save without an end")
