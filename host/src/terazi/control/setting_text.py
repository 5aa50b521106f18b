# SPDX-License-Identifier: MIT
"""One setting as people write and read it: names of values, units, bounds."""

import difflib
import re
from fractions import Fraction

from terazi.control.quantities import DIMENSIONS, parse
from terazi.errors import UsageError
from terazi.link.generated.settings import SETTINGS, SETTINGS_BY_NAME, Setting

NONE, ALL = "none", "all"
TRUE = ("true", "on", "yes", "1")
FALSE = ("false", "off", "no", "0")
ALIASES = {"e": "scale.interval_mg"}
LIST_REMEDY = "`terazi set --list` shows all names."
BY_REMEDY = {"calibration": "`terazi calibrate` writes it.", "command": "`terazi tare` writes it."}
CENTI = "1/100 "  # a unit that begins so is shown in whole ones
FORMAT = re.compile(r"_q(\d+)$")


def find_setting(name: str) -> Setting:
    """The setting of a full name, or of one without its group or unit where only one fits.

    Raises UsageError with what comes nearest.
    """
    wanted = name.strip().lower().replace("-", "_")
    wanted = ALIASES.get(wanted, wanted)
    if wanted in SETTINGS_BY_NAME:
        return SETTINGS_BY_NAME[wanted]
    fitting = [one for one in SETTINGS if wanted in _short_names(one)]
    if len(fitting) == 1:
        return fitting[0]
    if fitting:
        names = ", ".join(one.full_name for one in fitting)
        raise UsageError(f"{name!r} may mean {names}", remedy="Write one of them in full.")
    known = {short: one.full_name for one in SETTINGS for short in _short_names(one)}
    near = difflib.get_close_matches(wanted, [*SETTINGS_BY_NAME, *known], n=3, cutoff=0.5)
    names = dict.fromkeys(known.get(one, one) for one in near)
    raise UsageError(
        f"there is no setting {name!r}",
        remedy=f"Did you mean {' or '.join(names)}? {LIST_REMEDY}" if names else LIST_REMEDY,
    )


def parse_value(setting: Setting, text: str) -> int:
    """The value that a text says. Raises UsageError: not of this kind, or out of range."""
    if setting.by:
        raise UsageError(f"{setting.full_name} is not set by hand", remedy=BY_REMEDY[setting.by])
    text = text.strip()
    if setting.is_bool:
        return _bool(setting, text)
    if setting.choices:
        return _chosen(setting, text)
    value = _number(setting, text)
    if not setting.minimum <= value <= setting.maximum:
        raise UsageError(
            f"{setting.full_name} = {text} is out of range",
            remedy=f"It lies between {_in_unit(setting, setting.minimum)} and "
            f"{_in_unit(setting, setting.maximum)}.",
        )
    return value


def show_value(setting: Setting, value: int) -> str:
    """A value as parse_value reads it, without its unit."""
    if setting.is_bool:
        return "true" if value else "false"
    if setting.is_flags:
        names = [name for name, bits in setting.choices if value & bits]
        return "+".join(names) or NONE
    if setting.choices:
        return next((name for name, number in setting.choices if number == value), str(value))
    return str(value)


def show_with_unit(setting: Setting, value: int) -> str:
    """A value for people: 5000000 mg (5 kg), 26 (0.102 d), a_128."""
    text = show_value(setting, value)
    if setting.choices or setting.is_bool:
        return text
    plain = _in_larger_unit(setting, value)
    text = text if FORMAT.search(setting.name) else f"{text} {_raw_unit(setting)}".rstrip()
    return f"{text} ({plain})" if plain else text


def allowed(setting: Setting) -> str:
    """What it may be, in words."""
    if setting.is_bool:
        return "true or false"
    if setting.is_flags:
        return f"{', '.join(name for name, _bits in setting.choices)}, joined by +; {NONE}, {ALL}"
    if setting.choices:
        return ", ".join(name for name, _number in setting.choices)
    return f"{_in_unit(setting, setting.minimum)} to {_in_unit(setting, setting.maximum)}"


def _short_names(setting: Setting) -> list[str]:
    """Without its group; without its unit."""
    bare = setting.name
    for ending in (*DIMENSIONS["mass"], *DIMENSIONS["time"]):
        bare = bare.removesuffix(f"_{ending}")
    return [setting.name, f"{setting.group}.{bare}", bare]


def _bool(setting: Setting, text: str) -> int:
    if text.lower() in TRUE + FALSE:
        return int(text.lower() in TRUE)
    raise UsageError(f"{setting.full_name} is true or false, not {text!r}")


def _chosen(setting: Setting, text: str) -> int:
    choices = dict(setting.choices)
    if setting.is_flags and text.lower() in (ALL, NONE):
        return sum(choices.values()) if text.lower() == ALL else 0
    names = re.split(r"[+,| ]+", text.lower()) if setting.is_flags else [text.lower()]
    value = 0
    for name in (_in_full(one, choices) for one in names):
        if name not in choices:
            near = difflib.get_close_matches(name, choices, n=1)
            hint = f"Did you mean {near[0]}? " if near else ""
            raise UsageError(
                f"{setting.full_name} cannot be {name!r}", remedy=f"{hint}It is {allowed(setting)}."
            )
        value |= choices[name]
    return value


def _in_full(name: str, choices: dict[str, int]) -> str:
    """500000 for b500000, 64 for a_64: a number whose letters are missing, where only one fits."""
    if not name.isdecimal():
        return name
    fitting = [one for one in choices if re.fullmatch(rf"[a-z]+_?{name}", one)]
    return fitting[0] if len(fitting) == 1 else name


def _number(setting: Setting, text: str) -> int:
    centi = setting.unit.removeprefix(CENTI)
    if centi != setting.unit and text.endswith(centi):
        value = parse(text.removesuffix(centi), "") * 100
    else:
        value = parse(text, setting.unit)
    if value.denominator != 1:
        raise UsageError(
            f"{setting.full_name} = {text} is no whole number of {_raw_unit(setting) or 'units'}"
        )
    return int(value)


def _raw_unit(setting: Setting) -> str:
    """Of the number as it travels."""
    found = FORMAT.search(setting.name)
    return f"{setting.unit}/{1 << int(found[1])}" if found else setting.unit


def _in_unit(setting: Setting, value: int) -> str:
    return f"{value} {_raw_unit(setting)}".rstrip()


def _in_larger_unit(setting: Setting, value: int) -> str:
    """The same in a unit that is easier to read; "" where there is none."""
    if found := FORMAT.search(setting.name):
        return f"{value / (1 << int(found[1])):.4g} {setting.unit}"
    centi = setting.unit.removeprefix(CENTI)
    if centi != setting.unit:
        return f"{value / 100:.2f} {centi}"
    larger = {"mg": (Fraction(1000), "g"), "us": (Fraction(1_000_000), "s")}.get(setting.unit)
    if larger is None or not value:
        return ""
    factor, unit = larger
    return f"{float(value / factor):g} {unit}"
