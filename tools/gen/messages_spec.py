# SPDX-License-Identifier: MIT
"""messages.toml as checked objects, and the fingerprint of the wire."""

from __future__ import annotations

from dataclasses import dataclass

from tools.gen.spec import Spec, SpecError

TYPE_BYTES = {"u8": 1, "u16": 2, "u32": 4, "i16": 2, "i32": 4}
C_TYPES = {"u8": "uint8_t", "u16": "uint16_t", "u32": "uint32_t"}
C_TYPES |= {"i16": "int16_t", "i32": "int32_t"}
PAYLOAD_MAX_BYTES = 48  # FRAME_PAYLOAD_MAX in frame.h; the generated C asserts it again


@dataclass(frozen=True)
class Choice:
    """One enumerator, or one flag with its value 1 << bit."""

    name: str
    value: int
    summary: str


@dataclass(frozen=True)
class Group:
    """An enumeration or a set of flags."""

    name: str
    summary: str
    is_flags: bool
    choices: tuple[Choice, ...]


@dataclass(frozen=True)
class Field:
    """One field of a message, packed little-endian."""

    name: str
    type: str
    unit: str
    summary: str
    group: Group | None
    range: tuple[int, int] | None

    @property
    def size_bytes(self) -> int:
        return TYPE_BYTES[self.type]

    @property
    def type_range(self) -> tuple[int, int]:
        bits = 8 * self.size_bytes
        lowest = -(1 << bits - 1) if self.type[0] == "i" else 0
        return lowest, lowest + (1 << bits) - 1


@dataclass(frozen=True)
class Message:
    """One message: id, direction and fields in order."""

    name: str
    id: int
    direction: str
    summary: str
    fields: tuple[Field, ...]

    @property
    def len_bytes(self) -> int:
        return sum(field.size_bytes for field in self.fields)


@dataclass(frozen=True)
class Wire:
    """All of messages.toml."""

    groups: tuple[Group, ...]
    messages: tuple[Message, ...]
    fingerprint: int


def crc16_mcrf4xx(data: bytes) -> int:
    """CRC-16/MCRF4XX, here so that the generator needs no compiled code."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x8408 if crc & 1 else 0)
    return crc


def canonical_text(messages: tuple[Message, ...], groups: tuple[Group, ...]) -> str:
    """What the fingerprint covers: ids, names, types, order and the values that have names."""
    lines = []
    for group in groups:
        kind = "flags" if group.is_flags else "enum"
        lines.append(f"{kind} {group.name}")
        lines += [f" {choice.name}={choice.value}" for choice in group.choices]
    for message in messages:
        lines.append(f"message {message.id:#04x} {message.name} {message.direction}")
        lines += [f" {field.name}:{field.type}" for field in message.fields]
    return "\n".join(lines) + "\n"


def _groups(spec: Spec) -> tuple[Group, ...]:
    groups = []
    for is_flags, key in ((False, "enum"), (True, "flags")):
        for entry in spec.content.get(key, []):
            choices = tuple(
                Choice(
                    value["name"],
                    1 << value["bit"] if is_flags else value["value"],
                    value.get("summary", ""),
                )
                for value in entry["values"]
            )
            if len({choice.value for choice in choices}) != len(choices):
                raise SpecError(f"{key} {entry['name']}: two names for one value")
            groups.append(Group(entry["name"], entry.get("summary", ""), is_flags, choices))
    return tuple(groups)


def _field(entry: dict, groups: dict[str, Group], where: str) -> Field:
    if entry["type"] not in TYPE_BYTES:
        raise SpecError(f"{where}.{entry['name']}: unknown type {entry['type']}")
    group_name = entry.get("enum") or entry.get("flags")
    if group_name is not None and group_name not in groups:
        raise SpecError(f"{where}.{entry['name']}: unknown enum or flags {group_name}")
    limits = entry.get("range")
    field = Field(
        entry["name"],
        entry["type"],
        entry.get("unit", ""),
        entry.get("summary", ""),
        groups[group_name] if group_name else None,
        tuple(limits) if limits else None,
    )
    lowest, highest = field.type_range
    if field.group and max(choice.value for choice in field.group.choices) > highest:
        raise SpecError(f"{where}.{entry['name']}: {group_name} does not fit in {field.type}")
    if limits and not lowest <= limits[0] <= limits[1] <= highest:
        raise SpecError(f"{where}.{entry['name']}: range {limits} does not fit in {field.type}")
    return field


def parse(spec: Spec) -> Wire:
    """Check messages.toml and give it as objects."""
    groups = _groups(spec)
    by_name = {group.name: group for group in groups}
    messages = []
    for entry in spec.content["message"]:
        fields = tuple(_field(field, by_name, entry["name"]) for field in entry["fields"])
        message = Message(entry["name"], entry["id"], entry["direction"], entry["summary"], fields)
        if message.direction not in ("to_host", "to_device"):
            raise SpecError(f"{message.name}: unknown direction {message.direction}")
        if message.len_bytes > PAYLOAD_MAX_BYTES:
            raise SpecError(f"{message.name}: {message.len_bytes} bytes > {PAYLOAD_MAX_BYTES}")
        if len({field.name for field in fields}) != len(fields):
            raise SpecError(f"{message.name}: two fields of one name")
        messages.append(message)
    for key in ("id", "name"):
        if len({getattr(message, key) for message in messages}) != len(messages):
            raise SpecError(f"two messages with one {key}")
    fingerprint = crc16_mcrf4xx(canonical_text(tuple(messages), groups).encode())
    return Wire(groups, tuple(messages), fingerprint)
