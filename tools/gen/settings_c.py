# SPDX-License-Identifier: MIT
"""Renders settings_table.h and settings_table.c."""

from __future__ import annotations

from tools.gen.settings_spec import CRC_BYTES, HEAD_BYTES, TYPES, Setting, Settings
from tools.gen.spec import Spec, SpecError, c_comment_head

STRUCTS = {"scale": "scale", "checkweigher": "checkweigher", "temperature": "temperature"}
STRUCTS |= dict.fromkeys(("acc", "gyro", "mag"), "imu_cal")
PROTECTED = 0x80  # a place of limits stays below it
MIRRORED = 0x80  # the least value is minus the greatest
NO_KEY = 0xFF


def _key(setting: Setting) -> str:
    return f"SETTINGS_KEY_{setting.group}_{setting.name}".upper()


def _limit_bytes(setting: Setting) -> bytes:
    """The least value, where it is small, or the mark of minus the greatest; then the greatest."""
    least = MIRRORED if setting.minimum < 0 else setting.minimum
    return bytes([least]) + setting.maximum.to_bytes(setting.width, "little")


def _limits(settings: Settings) -> tuple[bytes, dict[tuple[int, bytes], int], list[int]]:
    """Limits one behind another, narrow types first; where each stands; where a width begins."""
    table, places, begins = b"", {}, []
    for width in (1, 2, 4):
        begins.append(len(table))
        for setting in settings.settings:
            limits = _limit_bytes(setting)
            if setting.width == width and (width, limits) not in places:
                places[width, limits] = len(table)
                table += limits
    if len(table) > PROTECTED:
        raise SpecError("settings.toml: too many ranges")
    return table, places, begins


def _factory(settings: Settings) -> bytes:
    """Keys whose factory value is not 0, each with its value; behind them no key."""
    rows = (bytes([one.key]) + one.stored for one in settings.settings if one.default)
    return b"".join(rows) + bytes([NO_KEY])


def _members(settings: Settings) -> list[str]:
    """The struct's members that belong to no module's configuration, wide ones first."""
    own = [one for one in settings.settings if one.member.isidentifier()]
    own.sort(key=lambda one: -one.width)
    return [f"    {TYPES[one.type]} {one.member};" for one in own]


def header(spec: Spec, settings: Settings) -> str:
    """Text of settings_table.h."""
    table, _, begins = _limits(settings)
    payload_len = len(settings.payload)
    own_names = {entry["name"] for entry in spec.content["values"]} - {"bool", "scale_option"}
    lines = [
        "/* settings_table - settings_t, keys and tables of shared_c/spec/settings.toml. */",
        "#ifndef SETTINGS_TABLE_H",
        "#define SETTINGS_TABLE_H",
        "",
        '#include "checkweigher.h"',
        '#include "imu_cal.h"',
        '#include "port_rom.h"',
        '#include "scale.h"',
        '#include "settings.h"',
        '#include "temperature.h"',
        "",
        "#include <stdint.h>",
        "",
        "enum {",
        f"    SETTINGS_VERSION       = {settings.version},",
        f"    SETTINGS_KEYS          = {len(settings.settings)},",
        f"    SETTINGS_PAYLOAD_LEN   = {payload_len}, /* bytes of all values */",
        f"    SETTINGS_RECORD_LEN    = {HEAD_BYTES + payload_len + CRC_BYTES},",
        f"    SETTINGS_LIMIT_BYTES   = {len(table)},",
        f"    SETTINGS_LIMITS_16     = {begins[1]}, /* where those of 16 bits begin */",
        f"    SETTINGS_LIMITS_32     = {begins[2]},",
        f"    SETTINGS_FACTORY_BYTES = {len(_factory(settings))},",
        f"    SETTINGS_PROTECTED     = {PROTECTED}, /* not written by key */",
        f"    SETTINGS_MIRRORED      = {MIRRORED},",
        "};",
        "",
        "/* Keys: for ever. */",
        "enum {",
        *(f"    {_key(one)} = {one.key}," for one in settings.settings),
        "};",
        "",
    ]
    for one in settings.settings:
        group = one.choices
        if group and group.name in own_names:
            own_names.remove(group.name)
            lines += [f"/* Values of {one.full_name}. */", "enum {"]
            stem = f"SETTINGS_{group.name}".upper()
            for choice in group.choices:
                lines.append(
                    f"    {stem}_{choice.name.upper()} = {choice.value}, /* {choice.summary} */"
                )
            lines += ["};", ""]
    lines += [
        "/* What outlives a reset: the configurations themselves, in their only copy. */",
        "struct settings {",
        *(f"    {kind}_config_t {name};" for name, kind in STRUCTS.items()),
        *_members(settings),
        "};",
        "",
        "/* By key: place in settings_t; place of its limits, SETTINGS_PROTECTED. */",
        "typedef struct {",
        "    port_place_t place;",
        "    uint8_t      limits;",
        "} settings_entry_t;",
        "",
        "extern const settings_entry_t settings_table[SETTINGS_KEYS]; /* ROM */",
        "",
        "/* Least value, or SETTINGS_MIRRORED for minus the greatest; the greatest, in the type's",
        " * width, little-endian. ROM */",
        "extern const uint8_t settings_limits[SETTINGS_LIMIT_BYTES];",
        "",
        "/* What leaves the factory as another value than 0, by rising keys: the key, the value in",
        " * its width, little-endian; behind the last one no key. ROM */",
        "extern const uint8_t settings_factory[SETTINGS_FACTORY_BYTES];",
    ]
    return c_comment_head(spec) + "\n".join([*lines, "", "#endif", ""])


def _bytes(data: bytes) -> list[str]:
    rows = [data[at : at + 16] for at in range(0, len(data), 16)]
    return ["    " + " ".join(f"0x{byte:02X}," for byte in row) for row in rows]


def source(spec: Spec, settings: Settings) -> str:
    """Text of settings_table.c."""
    limits, places, _ = _limits(settings)
    lines = [
        '#include "settings_table.h"',
        "",
        "#include <stddef.h>",
        "",
        "#define PLACE(member) (port_place_t)offsetof(settings_t, member)",
        "#define WIDTH(member) (uint8_t)sizeof(((settings_t *)0)->member)",
        "",
        "#define LAST (sizeof(settings_t) - 1)",
        "",
        '_Static_assert(LAST == (port_place_t)LAST, "every byte has a place");',
    ]
    for one in settings.settings:
        lines.append(f'_Static_assert(WIDTH({one.member}) == {one.width}, "as {one.type}");')
    lines += ["", "const settings_entry_t settings_table[SETTINGS_KEYS] PORT_ROM = {"]
    for one in settings.settings:
        place = places[one.width, _limit_bytes(one)]
        flag = " | SETTINGS_PROTECTED" if one.by else ""
        lines.append(f"    {{PLACE({one.member}), {place}{flag}}}, /* {one.full_name} */")
    lines += ["};", "", "const uint8_t settings_limits[SETTINGS_LIMIT_BYTES] PORT_ROM = {"]
    lines += [*_bytes(limits), "};", ""]
    lines += ["const uint8_t settings_factory[SETTINGS_FACTORY_BYTES] PORT_ROM = {"]
    lines += [*_bytes(_factory(settings)), "};", ""]
    return c_comment_head(spec) + "\n".join(lines)
