# SPDX-License-Identifier: MIT
"""Settings as TOML text, both ways."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import NoReturn

from terazi.errors import CannotRead
from terazi.link.generated.messages import Point
from terazi.link.generated.settings import SETTING_GROUPS, SETTINGS, SETTINGS_BY_NAME, Setting

POINTS_MIN, POINTS_MAX = 2, 8
CALIBRATION, POINTS = "calibration", "points"
POINT_FIELDS = ("counts_q7", "mass_mg")
COMMENT_COLUMN = 40


@dataclass(frozen=True)
class SettingsFile:
    """What a file holds: values by full name, and points where it has any."""

    settings: dict[str, int] = field(default_factory=dict)
    points: tuple[Point, ...] | None = None


def points_of(values: Mapping[str, int]) -> tuple[Point, ...]:
    """The calibration's points among values by full name."""
    fields = [[f"{CALIBRATION}.point_{name}_{at}" for name in POINT_FIELDS] for at in range(8)]
    count = values[f"{CALIBRATION}.{POINTS}"]
    return tuple(
        Point(at, *(values[name] for name in names)) for at, names in enumerate(fields[:count])
    )


# --- writing ---


def render_settings(values: Mapping[str, int], heading: Sequence[str] = ()) -> str:
    """TOML of all settings; heading: lines for people, which stand above as comments.

    values : by full name, of every setting.
    """
    lines = [f"# {_plain(line)}".rstrip() for text in heading for line in text.splitlines() or [""]]
    for group, summary in SETTING_GROUPS:
        lines += ["", f"[{group}]", f"# {_plain(summary)}"]
        for setting in SETTINGS:
            if setting.group == group:
                lines += _lines(setting, values)
    return "\n".join(lines).lstrip("\n") + "\n"


def _lines(setting: Setting, values: Mapping[str, int]) -> list[str]:
    if setting.by == CALIBRATION:
        return _point_lines(values) if setting.name == POINTS else []
    line = f"{setting.name} = {_value(setting, values[setting.full_name])}"
    if setting.by:
        line = f"# {line}"  # the device's own, told but not taken back
    return [f"{line:<{COMMENT_COLUMN}} # {_plain(setting.summary)}"]


def _point_lines(values: Mapping[str, int]) -> list[str]:
    lines = [f"{POINTS} = ["]
    for point in points_of(values):
        fields = (f"{name} = {getattr(point, name)}" for name in POINT_FIELDS)
        lines.append(f"    {{ {', '.join(fields)} }},")
    return [*lines, "]"]


def _value(setting: Setting, value: int) -> str:
    if setting.is_bool:
        return "true" if value else "false"
    if setting.is_flags:
        return "[" + ", ".join(f'"{name}"' for name, bits in setting.choices if value & bits) + "]"
    names = {number: name for name, number in setting.choices}
    return f'"{names[value]}"' if value in names else str(value)


def _plain(text: str) -> str:
    """Fit for a comment: TOML allows no control characters there."""
    return "".join(char if char.isprintable() else " " for char in text)


# --- reading ---


def read_settings_file(path: Path) -> SettingsFile:
    """A file's settings. Raises CannotRead, which names file, key, reason and remedy."""
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise CannotRead(f"{path} is no text", remedy="TOML is UTF-8.") from None
    except OSError as error:
        raise CannotRead(f"cannot read {path}: {error.strerror or error}") from None
    return parse_settings(text, str(path))


def parse_settings(text: str, where: str) -> SettingsFile:
    """Settings from TOML, strictly: an unknown key, a wrong type or range is refused as a whole.

    where : what to call the text in errors. Raises CannotRead.
    """
    try:
        content = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise CannotRead(
            f"{where} is no TOML: {error}", remedy="`terazi set --export` writes a good one."
        ) from None
    groups = [group for group, _summary in SETTING_GROUPS]
    settings, points = {}, None
    for group, table in content.items():
        if group not in groups:
            homes = [one.group for one in SETTINGS if one.name == group]
            if homes:
                _refuse(where, group, "is no group", f"It belongs under [{homes[0]}].")
            _refuse_name(where, group, groups, "group")
        if not isinstance(table, dict):
            _refuse(where, group, "is no table", f"Write [{group}] above its settings.")
        for name, value in table.items():
            if (group, name) == (CALIBRATION, POINTS):
                points = _points(value, where)
            else:
                setting = _known(group, name, where)
                settings[setting.full_name] = _checked(setting, value, where)
    return SettingsFile(settings, points)


def _refuse(where: str, key: str, reason: str, remedy: str) -> NoReturn:
    raise CannotRead(f"{where}: {key} {reason}", remedy=remedy)


def _refuse_name(where: str, name: str, known: Sequence[str], kind: str) -> NoReturn:
    near = difflib.get_close_matches(name, known, n=1)
    hint = f"Did you mean {near[0]}?" if near else f"There are {', '.join(known)}."
    _refuse(
        where,
        name,
        f"is no {kind} that this host knows",
        f"{hint} A file of a newer Terazi wants a newer host.",
    )


def _known(group: str, name: str, where: str) -> Setting:
    setting = SETTINGS_BY_NAME.get(f"{group}.{name}")
    if setting is None:
        known = [one.full_name for one in SETTINGS if one.group == group and not one.by]
        known += [f"{CALIBRATION}.{POINTS}"] if group == CALIBRATION else []
        _refuse_name(where, f"{group}.{name}", known, "setting")
    if setting.by == CALIBRATION:
        remedy = "Write them as points = [{ counts_q7 = ..., mass_mg = ... }, ...]."
        _refuse(where, setting.full_name, "is part of the calibration's points", remedy)
    if setting.by:
        remedy = "Take the line out; `terazi tare` sets it on the device."
        _refuse(where, setting.full_name, "is the device's own", remedy)
    return setting


def _checked(setting: Setting, value: object, where: str) -> int:
    """The value as it travels."""
    if setting.is_bool:
        if not isinstance(value, bool):
            _refuse(where, setting.full_name, f"is {_kind(value)}", "It is true or false.")
        return int(value)
    if setting.choices:
        return _chosen(setting, value, where)
    return _whole(value, setting.minimum, setting.maximum, setting.full_name, where)


def _whole(value: object, minimum: int, maximum: int, key: str, where: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool):
        _refuse(where, key, f"is {_kind(value)}", "It is a whole number.")
    if not minimum <= value <= maximum:
        remedy = f"It lies between {minimum} and {maximum}."
        _refuse(where, key, f"= {value} is out of range", remedy)
    return value


def _chosen(setting: Setting, value: object, where: str) -> int:
    choices = dict(setting.choices)
    names = ", ".join(f'"{name}"' for name in choices)
    remedy = f"It is a list of {names}." if setting.is_flags else f"It is one of {names}."
    given = value if setting.is_flags else [value]
    if not isinstance(given, list) or not all(isinstance(name, str) for name in given):
        _refuse(where, setting.full_name, f"is {_kind(value)}", remedy)
    for name in given:
        if name not in choices:
            _refuse(where, setting.full_name, f'cannot be "{_plain(name)}"', remedy)
    if len(set(given)) != len(given):
        _refuse(where, setting.full_name, "names one value twice", remedy)
    return sum(choices[name] for name in given)


def _points(value: object, where: str) -> tuple[Point, ...]:
    key = f"{CALIBRATION}.{POINTS}"
    remedy = "It is a list of { counts_q7 = ..., mass_mg = ... }, 2 to 8 of them."
    if not isinstance(value, list) or not POINTS_MIN <= len(value) <= POINTS_MAX:
        _refuse(where, key, "is no list of 2 to 8 points", remedy)
    points = []
    for at, entry in enumerate(value):
        if not isinstance(entry, dict) or set(entry) != set(POINT_FIELDS):
            _refuse(where, f"{key}[{at}]", "is no point", remedy)
        fields = []
        for name in POINT_FIELDS:
            bounds = SETTINGS_BY_NAME[f"{CALIBRATION}.point_{name}_{at}"]
            place = f"{key}[{at}].{name}"
            fields.append(_whole(entry[name], bounds.minimum, bounds.maximum, place, where))
        points.append(Point(at, *fields))
    masses = [point.mass_mg for point in points]
    if any(low >= high for low, high in pairwise(masses)):
        _refuse(where, key, "are not in the order of their masses", "Let each mass be greater.")
    return tuple(points)


def _kind(value: object) -> str:
    kinds = {bool: "a truth value", int: "a whole number", float: "a number with a point"}
    kinds |= {str: "a text", list: "a list", dict: "a table"}
    return kinds.get(type(value), "a date or time")
