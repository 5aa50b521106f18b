# SPDX-License-Identifier: MIT
"""Renders terazi/link/generated/settings.py."""

from __future__ import annotations

from tools.gen.settings_spec import Setting, Settings
from tools.gen.spec import Spec, python_head

PREAMBLE = '''\
"""Settings of the device by key: names, units, ranges, defaults. Table: shared_c/PROTOCOL.md"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


@dataclass(frozen=True)
class Setting:
    """One setting. It travels as an i32 under its key."""

    key: int
    group: str
    name: str  # its unit and format stand at its end
    type: str  # in a record: u8 i8 u16 i16 u32 i32
    unit: str
    minimum: int
    maximum: int
    default: int  # as it leaves the factory
    choices: tuple[tuple[str, int], ...]  # names of values, or of bits where is_flags
    is_flags: bool
    is_bool: bool
    by: str  # what writes it where that is not a key: "calibration", "command"; else ""
    summary: str

    @property
    def full_name(self) -> str:
        """group.name, by which people call it."""
        return f"{self.group}.{self.name}"

'''


def _key(setting: Setting) -> str:
    return f"{setting.group}_{setting.name}".upper()


def _setting(one: Setting) -> list[str]:
    is_bool = one.is_bool
    choices = () if one.choices is None or is_bool else one.choices.choices
    names = tuple((choice.name, choice.value) for choice in choices)
    is_flags = one.choices is not None and one.choices.is_flags
    words = (one.key, one.group, one.name, one.type, one.unit, one.minimum, one.maximum)
    head = ", ".join(map(repr, (*words, one.default)))
    return [
        "    Setting(",
        f"        {head},",
        f"        {names!r}, {is_flags}, {is_bool}, {one.by!r},",
        f"        {one.summary!r},",
        "    ),",
    ]


def module(spec: Spec, settings: Settings) -> str:
    """Text of the module."""
    lines = [
        "",
        "class SettingKey(IntEnum):",
        '    """Keys, for ever."""',
        "",
        *(f"    {_key(one)} = {one.key}" for one in settings.settings),
        "",
        "",
        f"RECORD_VERSION = {settings.version}",
        f"RECORD_PAYLOAD_LEN = {len(settings.payload)}  # bytes",
        "",
        "SETTING_GROUPS: tuple[tuple[str, str], ...] = (",
        *(f"    ({name!r}, {summary!r})," for name, summary in settings.groups),
        ")",
        "",
        "SETTINGS: tuple[Setting, ...] = (",
        *(line for one in settings.settings for line in _setting(one)),
        ")",
        '"""By key."""',
        "",
        "SETTINGS_BY_NAME: dict[str, Setting] = {one.full_name: one for one in SETTINGS}",
        "",
    ]
    return python_head(spec) + PREAMBLE + "\n".join(lines)
