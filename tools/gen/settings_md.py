# SPDX-License-Identifier: MIT
"""Renders the settings' part of shared_c/PROTOCOL.md."""

from __future__ import annotations

from tools.gen.settings_spec import Setting, Settings
from tools.gen.spec import Spec

INTRODUCTION = """\
## Settings

Each is read and written by its key (GET_SETTING, SET_SETTING) and travels as an i32. Some are
written by a calibration or a command only. In EEPROM they stand in the order of their keys, each
in its type, little-endian; [the derivation](notes/settings.md) tells what a record looks like.
"""


def _range(setting: Setting) -> str:
    if setting.choices is None or setting.is_bool:
        return f"{setting.minimum}..{setting.maximum}"
    mark = "bits" if setting.choices.is_flags else ""
    names = (f"{choice.value} `{choice.name}`" for choice in setting.choices.choices)
    return ", ".join(names) + (f" ({mark})" if mark else "")


def section(spec: Spec, settings: Settings) -> str:
    """Text behind the messages."""
    lines = [f"<!-- {spec.origin} -->", INTRODUCTION]
    for group, summary in settings.groups:
        lines += [
            f"### {group}",
            "",
            summary,
            "",
            "| key | name | type | unit | range | factory | written by | meaning |",
            "|---|---|---|---|---|---|---|---|",
        ]
        for one in settings.settings:
            if one.group == group:
                words = (one.key, f"`{one.full_name}`", one.type, one.unit, _range(one))
                words += (one.default, one.by or "key", one.summary)
                lines.append("| " + " | ".join(map(str, words)) + " |")
        lines.append("")
    return "\n".join(lines)
