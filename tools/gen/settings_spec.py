# SPDX-License-Identifier: MIT
"""settings.toml as checked objects: every setting with its key, and what a record holds."""

from __future__ import annotations

from dataclasses import dataclass

from terazi.design import scale
from tools.gen.messages_spec import Choice, Group, Wire
from tools.gen.spec import Spec, SpecError

TYPES = {"u8": "uint8_t", "i8": "int8_t", "u16": "uint16_t", "i16": "int16_t"}
TYPES |= {"u32": "uint32_t", "i32": "int32_t"}
VALUE_MIN, VALUE_MAX = -(1 << 31), (1 << 31) - 1  # every setting travels as i32
HEAD_BYTES, CRC_BYTES, SLOT_BYTES = 5, 2, 256  # settings.h
KEYS_MAX = 255


@dataclass(frozen=True)
class Setting:
    """One key."""

    key: int
    group: str
    name: str
    member: str  # in settings_t
    type: str
    unit: str
    minimum: int
    maximum: int
    default: int
    choices: Group | None
    by: str  # "", "calibration" or "command"
    summary: str

    @property
    def full_name(self) -> str:
        return f"{self.group}.{self.name}"

    @property
    def width(self) -> int:
        return int(self.type[1:]) // 8

    @property
    def stored(self) -> bytes:
        """The factory's value as a record holds it."""
        return (self.default & (1 << 8 * self.width) - 1).to_bytes(self.width, "little")

    @property
    def is_bool(self) -> bool:
        return self.choices is not None and self.choices.name == "bool"


@dataclass(frozen=True)
class Settings:
    """All of settings.toml."""

    version: int
    groups: tuple[tuple[str, str], ...]  # name, summary
    settings: tuple[Setting, ...]

    @property
    def payload(self) -> bytes:
        """The factory's settings as a record holds them."""
        return b"".join(one.stored for one in self.settings)


def _choices(spec: Spec, wire: Wire) -> dict[str, Group]:
    groups = {group.name: group for group in wire.groups}
    for entry in spec.content["values"]:
        choices = (
            Choice(one["name"], one["value"], one.get("summary", "")) for one in entry["values"]
        )
        name = entry["name"]
        groups[name] = Group(name, "", entry["kind"] == "flags", tuple(choices))
    return groups


def _limits(entry: dict, choices: Group | None, where: str) -> tuple[int, int]:
    """Least and greatest value, checked against the type."""
    if choices is not None and "range" not in entry:
        values = [choice.value for choice in choices.choices]
        low, high = (0, sum(values)) if choices.is_flags else (min(values), max(values))
        if not choices.is_flags and len(values) != high - low + 1:
            raise SpecError(f"{where}: the values of {choices.name} leave gaps")
    else:
        low, high = entry["range"]
    bits = int(entry["type"][1:])
    lowest = -(1 << bits - 1) if entry["type"][0] == "i" else 0
    highest = min(lowest + (1 << bits) - 1, VALUE_MAX)
    if not lowest <= low < high <= highest or high < 0:
        raise SpecError(f"{where}: range {low}..{high} does not fit in {entry['type']}")
    if not 0 <= low < 1 << 7 and low != -high:
        raise SpecError(f"{where}: the least value is 0..127 or minus the greatest")
    return low, high


def _default(entry: dict, choices: Group | None, at: int, where: str) -> int:
    value = entry["default"]
    if value == "scale":
        given = scale.config()[entry["member"].removeprefix("scale.")]
        return given[at] if isinstance(given, list) else given
    if isinstance(value, int):
        return value
    by_name = {choice.name: choice.value for choice in choices.choices} if choices else {}
    if choices and choices.is_flags and value == "all":
        return sum(by_name.values())
    if value not in by_name:
        raise SpecError(f"{where}: no value is called {value!r}")
    return by_name[value]


def _settings(entry: dict, group: str, known: dict[str, Group]) -> list[Setting]:
    """The entry, or where it has a count, as many with keys in a row."""
    where = f"{group}.{entry['name']}"
    if entry["type"] not in TYPES:
        raise SpecError(f"{where}: unknown type {entry['type']}")
    named = entry.get("enum") or entry.get("flags")
    if named is not None and named not in known:
        raise SpecError(f"{where}: no values are called {named!r}")
    choices = known[named] if named else None
    low, high = _limits(entry, choices, where)
    found = []
    for at in range(entry.get("count", 1)):
        default = _default(entry, choices, at, where)
        if not low <= default <= high:
            raise SpecError(f"{where}: default {default} is not in {low}..{high}")
        member = entry.get("member", f"{group}_{entry['name']}")
        in_array = "count" in entry
        found.append(
            Setting(
                entry["key"] + at,
                group,
                f"{entry['name']}_{at}" if in_array else entry["name"],
                f"{member}[{at}]" if in_array else member,
                entry["type"],
                entry.get("unit", ""),
                low,
                high,
                default,
                choices,
                entry.get("by", ""),
                entry["summary"],
            )
        )
    return found


def parse(spec: Spec, wire: Wire) -> Settings:
    """Check settings.toml and give it as objects, in the order of keys."""
    known = _choices(spec, wire)
    found: list[Setting] = []
    for group in spec.content["group"]:
        for entry in group["settings"]:
            found += _settings(entry, group["name"], known)
    found.sort(key=lambda one: one.key)
    if [one.key for one in found] != list(range(len(found))) or len(found) > KEYS_MAX:
        raise SpecError("settings.toml: keys must be 0, 1, 2 ... without gaps")
    if len({one.full_name for one in found}) != len(found):
        raise SpecError("settings.toml: two settings with one name")
    groups = tuple((group["name"], group["summary"]) for group in spec.content["group"])
    settings = Settings(spec.content["version"], groups, tuple(found))
    if HEAD_BYTES + len(settings.payload) + CRC_BYTES > SLOT_BYTES:
        raise SpecError(f"settings.toml: {len(settings.payload)} bytes do not fit in a slot")
    return settings
