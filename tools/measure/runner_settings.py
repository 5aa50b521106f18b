# SPDX-License-Identifier: MIT
"""What makes the chip save settings: whole records into blank slots, then single values."""

from __future__ import annotations

import struct

from target_vectors.avr_core import AvrCore
from terazi.link.generated.settings import SettingKey

SAVES = 6  # more than there are slots


def drive(core: AvrCore) -> None:
    """A new chip's EEPROM is blank."""
    core.request("l")
    for number in range(SAVES):
        core.request("s", struct.pack("<Bi", SettingKey.SCALE_MAX_MG, 1_000_000 + number))
        core.request("S")
