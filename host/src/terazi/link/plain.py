# SPDX-License-Identifier: MIT
"""Messages in plain numbers and words: for tables, JSON and pages."""

import dataclasses
import enum

from terazi import units


def plain_message(message) -> dict:
    """Field by field: rates in Hz under a name without its format, enumerations as words."""
    plain = {}
    for field in dataclasses.fields(message):
        value = getattr(message, field.name)
        if field.name.endswith("_hz_q16"):
            plain[field.name.removesuffix("_q16")] = round(units.hz_from_q16(value), 4)
        elif isinstance(value, enum.Flag):
            plain[field.name] = int(value)
        elif isinstance(value, enum.Enum):
            plain[field.name] = value.name.lower()
        else:
            plain[field.name] = value
    return plain
