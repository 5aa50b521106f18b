# SPDX-License-Identifier: MIT
"""Renders messages.h and messages.c."""

from __future__ import annotations

import textwrap

from tools.gen.messages_spec import C_TYPES, Field, Message, Wire
from tools.gen.spec import Spec, c_comment_head

HEADER_CONTRACT = """\
/* messages - the payloads on the wire and their codec. Table for readers: shared_c/PROTOCOL.md
 *
 * Formats   fields in the order of messages.toml, little-endian, without padding
 * Bad data  unpack refuses (false) a payload of another length or with a field outside its range,
 *           and then leaves *message as it was; pack writes what it is given
 * Context   any; no state.  Cost: firmware/budget.toml
 */
"""


def _comment(text: str) -> list[str]:
    """A C comment of lines no longer than 100 columns."""
    return textwrap.wrap(
        f"/* {text} */", 99, subsequent_indent=" * ", break_long_words=False, break_on_hyphens=False
    )


def _member(declaration: str, note: str) -> list[str]:
    """One line of a struct or enum, its note above where it does not fit behind."""
    if not note:
        return [f"    {declaration}"]
    line = f"    {declaration} /* {note} */"
    return [line] if len(line) <= 100 else [f"    /* {note} */", f"    {declaration}"]


def _prototype(result: str, name: str, arguments: list[str]) -> str:
    line = f"{result} {name}({', '.join(arguments)})"
    if len(line) < 100:
        return line
    indent = " " * (len(result) + len(name) + 2)
    return f"{result} {name}(" + f",\n{indent}".join(arguments) + ")"


def _pack(message: Message) -> str:
    arguments = ["uint8_t payload[]", f"const messages_{message.name}_t *message"]
    return _prototype("uint8_t", f"messages_{message.name}_pack", arguments)


def _unpack(message: Message) -> str:
    arguments = [f"messages_{message.name}_t *message", "const uint8_t payload[]", "uint8_t len"]
    return _prototype("bool", f"messages_{message.name}_unpack", arguments)


def _choices(wire: Wire) -> list[str]:
    lines = []
    for group in wire.groups:
        prefix = f"MESSAGES_{group.name.upper()}"
        names = [f"{prefix}_{choice.name.upper()}" for choice in group.choices]
        width = max(map(len, names))
        lines += [*_comment(group.summary), "enum {"]
        for name, choice in zip(names, group.choices, strict=True):
            value = f"0x{choice.value:02X}" if group.is_flags else f"{choice.value}"
            lines += _member(f"{name:<{width}} = {value},", choice.summary)
        lines += ["};", ""]
    return lines


def _limits(wire: Wire) -> list[str]:
    """What a command's fields may be, for a device that reads them without unpack."""
    lines = ["/* Ranges of commands' fields, where they are narrower than the type. */"]
    for message in wire.messages:
        for field in message.fields if message.direction == "to_device" else ():
            limits = zip(("MIN", "MAX"), field.range or (), field.type_range, strict=False)
            for word, limit, extreme in limits:
                if limit != extreme:
                    name = f"MESSAGES_{message.name}_{field.name}_{word}".upper()
                    lines.append(f"#define {name} {_plain_literal(limit)}")
    return [*lines, ""]


def _plain_literal(value: int) -> str:
    """A C constant that cffi reads, too."""
    if -32768 < value < 32768:
        return f"{value}" if value >= 0 else f"({value})"
    return f"{value}L" if value >= 0 else f"({value}L)"


def _note(field: Field) -> str:
    words = [field.unit] if field.unit else []
    if field.group:
        words.append(f"MESSAGES_{field.group.name.upper()}_...")
    if field.range:
        words.append(f"{field.range[0]}..{field.range[1]}")
    if field.summary:
        words.append(field.summary)
    return "; ".join(words)


def _struct(message: Message) -> list[str]:
    if not message.fields:
        return []
    lines = [*_comment(message.summary), "typedef struct {"]
    width = max(len(C_TYPES[field.type]) for field in message.fields)
    for field in message.fields:
        lines += _member(f"{C_TYPES[field.type]:<{width}} {field.name};", _note(field))
    return [*lines, f"}} messages_{message.name}_t;", ""]


def header(spec: Spec, wire: Wire) -> str:
    """Text of messages.h."""
    lines = [
        "#ifndef MESSAGES_H",
        "#define MESSAGES_H",
        "",
        "#include <stdbool.h>",
        "#include <stdint.h>",
        "",
        "/* CRC-16/MCRF4XX over ids, names, types and order; HELLO carries it. */",
        f"#define MESSAGES_FINGERPRINT 0x{wire.fingerprint:04X}U",
        "",
        "enum {",
    ]
    width = max(len(message.name) for message in wire.messages) + len("MESSAGES__LEN")
    for message in wire.messages:
        stem = f"MESSAGES_{message.name.upper()}"
        lines.append(f"    {stem + '_ID':<{width}} = 0x{message.id:02X},")
        lines.append(f"    {stem + '_LEN':<{width}} = {message.len_bytes}, /* bytes of payload */")
    lines += ["};", "", *_limits(wire), *_choices(wire)]
    for message in wire.messages:
        lines += _struct(message)
    lines.append("/* Write the payload; gives its length. */")
    for message in wire.messages:
        if message.fields:
            lines.append(_pack(message) + ";")
    lines += ["", "/* Read a payload of len bytes; false refuses it. */"]
    for message in wire.messages:
        if message.fields:
            lines.append(_unpack(message) + ";")
    lines += ["", "#endif", ""]
    return c_comment_head(spec) + HEADER_CONTRACT + "\n".join(lines)


def _put(field: Field, at: int) -> str:
    if field.type == "u8":
        return f"    payload[{at}] = message->{field.name};"
    value = f"message->{field.name}"
    raw = field.type.replace("i", "u")
    if field.type != raw:
        value = f"({C_TYPES[raw]}){value}"
    return f"    put_{raw}(&payload[{at}], {value});"


def _get(field: Field, at: int) -> str:
    if field.type == "u8":
        value = f"payload[{at}]"
    elif field.type[0] == "i":
        value = f"({C_TYPES[field.type]})get_{field.type.replace('i', 'u')}(&payload[{at}])"
    else:
        value = f"get_{field.type}(&payload[{at}])"
    return f"    read.{field.name} = {value};"


def _literal(value: int) -> str:
    """A C constant that is right where int has 16 bits, too."""
    return f"INT32_C({value})" if value >= 0 else f"(-INT32_C({-value}))"


def _range_tests(field: Field) -> list[str]:
    if field.range is None:
        return []
    tests = []
    lowest, highest = field.type_range
    suffix = field.type != "i32"
    for sign, limit, extreme in (("<", field.range[0], lowest), (">", field.range[1], highest)):
        if limit != extreme:
            literal = f"{limit}U" if suffix else _literal(limit)
            tests.append(f"read.{field.name} {sign} {literal}")
    return tests


def _codec(message: Message) -> list[str]:
    name, size = message.name, f"MESSAGES_{message.name.upper()}_LEN"
    offsets, at = [], 0
    for field in message.fields:
        offsets.append(at)
        at += field.size_bytes
    placed = list(zip(message.fields, offsets, strict=True))
    refusals = [test for field in message.fields for test in _range_tests(field)]
    return [
        f'_Static_assert({size} <= (int)FRAME_PAYLOAD_MAX, "fits in a frame");',
        f"_Static_assert(!PORT_WIRE_IS_STRUCT || sizeof(messages_{name}_t) == {size},",
        '               "no padding");',
        "",
        _pack(message),
        "{",
        "    if (PORT_WIRE_IS_STRUCT) {",
        f"        memcpy(payload, message, {size});",
        f"        return {size};",
        "    }",
        *(_put(field, at) for field, at in placed),
        f"    return {size};",
        "}",
        "",
        _unpack(message),
        "{",
        f"    messages_{name}_t read;",
        "",
        f"    if (len != {size}) {{ return false; }}",
        "    if (PORT_WIRE_IS_STRUCT) {",
        f"        memcpy(&read, payload, {size});",
        "    } else {",
        *("    " + _get(field, at) for field, at in placed),
        "    }",
        *(f"    if ({test}) {{ return false; }}" for test in refusals),
        "    *message = read;",
        "    return true;",
        "}",
        "",
    ]


HELPERS = {
    "put_u16": """\
static void put_u16(uint8_t at[], uint16_t value)
{
    at[0] = (uint8_t)value;
    at[1] = (uint8_t)(value >> 8);
}
""",
    "put_u32": """\
static void put_u32(uint8_t at[], uint32_t value)
{
    put_u16(&at[0], (uint16_t)value);
    put_u16(&at[2], (uint16_t)(value >> 16));
}
""",
    "get_u16": """\
static uint16_t get_u16(const uint8_t at[])
{
    return (uint16_t)(at[0] | (uint16_t)at[1] << 8);
}
""",
    "get_u32": """\
static uint32_t get_u32(const uint8_t at[])
{
    return get_u16(&at[0]) | (uint32_t)get_u16(&at[2]) << 16;
}
""",
}


def source(spec: Spec, wire: Wire) -> str:
    """Text of messages.c."""
    includes = ["#include <string.h>", "", '#include "frame.h"', '#include "port_wire.h"', ""]
    lines = []
    for message in wire.messages:
        if message.fields:
            lines += _codec(message)
    while lines[-1] == "":
        lines.pop()
    head = "\n".join(['#include "messages.h"', "", *includes, *HELPERS.values()])
    return c_comment_head(spec) + head + "\n" + "\n".join(lines) + "\n"
