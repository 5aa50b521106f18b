# SPDX-License-Identifier: MIT
"""Messages in plain numbers and words: for tables, JSON and pages."""

import dataclasses
import enum
import re

from terazi import units

# Fields that are shown in other units: what their names end with, what takes its place, how.
SHOWN = (
    (re.compile(r"_hz_q16$"), "_hz", units.hz_from_q16, 4),
    (re.compile(r"(?<=^quat_[wxyz])_q30$"), "", units.one_from_q30, 10),
    (re.compile(r"(?<=^bias_[xyz])_q16$"), "_deg_s", units.deg_s_from_q16, 5),
    (re.compile(r"(?<=^up_[xyz])_q14$"), "", units.one_from_q14, 5),
    (re.compile(r"^temp_counts$"), "temperature_deg_c", units.deg_c_from_counts, 3),
)


def plain_message(message) -> dict:
    """Field by field: rates in Hz and the like under a name without its format, enumerations as
    words."""
    plain = {}
    for field in dataclasses.fields(message):
        value = getattr(message, field.name)
        if isinstance(value, enum.Flag):
            plain[field.name] = int(value)
        elif isinstance(value, enum.Enum):
            plain[field.name] = value.name.lower()
        else:
            name, shown = _shown(field.name, value)
            plain[name] = shown
    return plain


def _shown(name: str, value: int) -> tuple[str, float | int]:
    for ending, instead, convert, decimals in SHOWN:
        if ending.search(name):
            return ending.sub(instead, name), round(convert(value), decimals)
    return name, value
