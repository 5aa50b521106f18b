# SPDX-License-Identifier: MIT
"""Renders terazi/link/generated/messages.py."""

from __future__ import annotations

from tools.gen.messages_spec import Field, Group, Message, Wire
from tools.gen.spec import Spec, python_head

PREAMBLE = '''\
"""Messages of the wire as frozen dataclasses; packed and read by the firmware's own C codec.

`pack` raises ValueError where a field does not fit its type; `unpack` does where the payload's
length or a field's range is not the spec's. Table for readers: shared_c/PROTOCOL.md
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import ClassVar

from terazi.cshared import pack_message, unpack_message

'''


def class_name(snake: str) -> str:
    """get_info -> GetInfo."""
    return "".join(part.capitalize() for part in snake.split("_"))


def _group(group: Group) -> list[str]:
    base = "IntFlag" if group.is_flags else "IntEnum"
    summary = group.summary if len(group.summary) <= 88 else group.summary[:85] + "..."
    lines = ["", f"class {class_name(group.name)}({base}):", f'    """{summary}"""', ""]
    for choice in group.choices:
        value = f"0x{choice.value:02X}" if group.is_flags else str(choice.value)
        comment = f"  # {choice.summary}" if choice.summary else ""
        lines.append(f"    {choice.name.upper()} = {value}{comment}")
    return [*lines, ""]


def _note(field: Field) -> str:
    words = [field.unit] if field.unit else []
    if field.range:
        words.append(f"{field.range[0]}..{field.range[1]}")
    if field.summary:
        words.append(field.summary)
    return "; ".join(words)


def _wrapped(text: str, indent: str, width: int = 96) -> list[str]:
    lines, line = [], indent
    for word in text.split():
        if len(line) + len(word) > width:
            lines.append(line.rstrip())
            line = indent
        line += word + " "
    return [*lines, line.rstrip()]


def _field_lines(field: Field) -> list[str]:
    if field.group and not field.group.is_flags:
        annotation = f"{class_name(field.group.name)} | int"
    elif field.group:
        annotation = class_name(field.group.name)
    else:
        annotation = "int"
    line, note = f"    {field.name}: {annotation}", _note(field)
    if note and len(line) + len(note) + 4 <= 100:
        return [f"{line}  # {note}"]
    return [*(_wrapped(note, "    # ") if note else []), line]


def _converters(message: Message) -> list[str]:
    grouped = [field for field in message.fields if field.group]
    if not grouped:
        return []
    lines = []
    for field in grouped:
        name = class_name(field.group.name)
        if field.group.is_flags:
            lines.append(f'        fields["{field.name}"] = {name}(fields["{field.name}"])')
        else:
            lines.append(f'        fields["{field.name}"] = _named({name}, fields["{field.name}"])')
    return lines


def _message(message: Message) -> list[str]:
    name = class_name(message.name)
    summary = _wrapped(f'"""{message.summary}', "    ")
    summary[-1] += '"""' if len(summary) == 1 else ""
    if len(summary) > 1:
        summary.append('    """')
    lines = ["", "@dataclass(frozen=True)", f"class {name}:", *summary, ""]
    lines += [
        f"    ID: ClassVar[int] = 0x{message.id:02X}",
        f"    LEN: ClassVar[int] = {message.len_bytes}",
        f'    NAME: ClassVar[str] = "{message.name}"',
    ]
    if message.fields:
        lines.append("")
    for field in message.fields:
        lines += _field_lines(field)
    lines += [
        "",
        "    def pack(self) -> bytes:",
        '        """The payload."""',
        f"        return pack_message(self.NAME, {'vars(self)' if message.fields else '{}'})",
        "",
        "    @classmethod",
        f"    def unpack(cls, payload: bytes) -> {name}:",
        '        """Read a payload, or raise ValueError."""',
    ]
    if message.fields:
        lines += ["        fields = unpack_message(cls.NAME, payload)", *_converters(message)]
        lines.append("        return cls(**fields)")
    else:
        lines += ["        unpack_message(cls.NAME, payload)", "        return cls()"]
    return [*lines, ""]


def _union(name: str, members: list[str]) -> list[str]:
    line = f"{name} = {' | '.join(members)}"
    if len(line) <= 100:
        return [line]
    return [f"{name} = (", f"    {members[0]}", *(f"    | {one}" for one in members[1:]), ")"]


def module(spec: Spec, wire: Wire) -> str:
    """Text of messages.py."""
    lines = [f"FINGERPRINT = 0x{wire.fingerprint:04X}", ""]
    for group in wire.groups:
        lines += _group(group)
    lines += [
        "",
        "def _named(kind: type[IntEnum], value: int) -> IntEnum | int:",
        '    """The enumerator, or the bare number where a newer device knows more than we do."""',
        "    return kind(value) if value in kind._value2member_map_ else value",
        "",
    ]
    for message in wire.messages:
        lines += _message(message)
    names = [class_name(message.name) for message in wire.messages]
    unions = {
        "to_host": [class_name(m.name) for m in wire.messages if m.direction == "to_host"],
        "to_device": [class_name(m.name) for m in wire.messages if m.direction == "to_device"],
    }
    lines += [
        "",
        *_union("ToHost", unions["to_host"]),
        *_union("ToDevice", unions["to_device"]),
        "",
        "MESSAGES_BY_ID: dict[int, type] = {",
        *(f"    {name}.ID: {name}," for name in names),
        "}",
        "",
    ]
    return python_head(spec) + PREAMBLE + "\n".join(lines)
