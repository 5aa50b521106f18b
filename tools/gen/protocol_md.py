# SPDX-License-Identifier: MIT
"""Renders shared_c/PROTOCOL.md, the table of the wire for readers."""

from __future__ import annotations

from tools.gen.messages_spec import Message, Wire
from tools.gen.spec import Spec

INTRODUCTION = """\
# The wire

115 200 baud, 8 data bits, no parity, 1 stop bit. Every frame is `COBS(body) 0x00`, where

| bytes | field | |
|---|---|---|
| 1 | `id` | which message, see below |
| 1 | `sequence` | counts the frames of one sender, modulo 256: a jump is a lost frame |
| 4 | `device_us` | the device's clock in microseconds, wraps after 71.6 minutes; a host sends 0 |
| 0..48 | payload | the message's fields in order, little-endian, without padding |
| 2 | `crc` | CRC-16/MCRF4XX (start 0xFFFF, `_crc_ccitt_update` of avr-libc) of all before it |

is the body, little-endian. COBS (Cheshire and Baker 1999) takes the zeros out: a body shorter
than 254 bytes becomes one byte longer. After an error a reader takes up again at the next 0x00.
`_qN` in a name means N fraction bits. The host refuses a device with another fingerprint.
"""


def _message(message: Message) -> list[str]:
    lines = [
        f"### 0x{message.id:02X} {message.name.upper()} ({message.len_bytes} bytes)",
        "",
        message.summary,
        "",
    ]
    if not message.fields:
        return [*lines, "No payload.", ""]
    lines += ["| offset | field | type | unit | range | meaning |", "|---|---|---|---|---|---|"]
    offset = 0
    for field in message.fields:
        limits = f"{field.range[0]}..{field.range[1]}" if field.range else ""
        meaning = "; ".join(
            part
            for part in (f"see {field.group.name}" if field.group else "", field.summary)
            if part
        )
        lines.append(
            f"| {offset} | `{field.name}` | {field.type} | {field.unit} | {limits} | {meaning} |"
        )
        offset += field.size_bytes
    return [*lines, ""]


def page(spec: Spec, wire: Wire) -> str:
    """Text of PROTOCOL.md."""
    lines = [
        f"<!-- {spec.origin} -->",
        INTRODUCTION,
        f"Fingerprint: `0x{wire.fingerprint:04X}`",
        "",
    ]
    for direction, title in (("to_host", "From device to host"), ("to_device", "Commands")):
        lines += [f"## {title}", ""]
        for message in wire.messages:
            if message.direction == direction:
                lines += _message(message)
    lines += ["## Values with names", ""]
    for group in wire.groups:
        kind = "bits" if group.is_flags else "values"
        lines += [f"### {group.name} ({kind})", "", group.summary, "", "| value | name | meaning |"]
        lines.append("|---|---|---|")
        for choice in group.choices:
            value = f"0x{choice.value:02X}" if group.is_flags else f"{choice.value}"
            lines.append(f"| {value} | `{choice.name}` | {choice.summary} |")
        lines.append("")
    return "\n".join(lines)
