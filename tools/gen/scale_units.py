# SPDX-License-Identifier: MIT
"""Renders the units and the default configuration of scale.toml."""

from __future__ import annotations

from terazi.design import scale
from tools.gen.spec import Spec, c_comment_head


def header(spec: Spec) -> str:
    """Text of scale_units.h."""
    names = [unit["name"].upper() for unit in spec.content["unit"]]
    lines = [
        "/* scale_units - units of shared_c/spec/scale.toml, and the scale never calibrated. */",
        "#ifndef SCALE_UNITS_H",
        "#define SCALE_UNITS_H",
        "",
        '#include "scale.h"',
        "",
        "enum {",
        *(f"    SCALE_UNIT_{name} = {at}," for at, name in enumerate(names)),
        f"    SCALE_UNIT_COUNT = {len(names)}",
        "};",
        "",
        "/* 1 / (10 units in mg): mantissa's upper and lower half, exponent. ROM */",
        "extern const uint16_t scale_unit_reciprocals[SCALE_UNIT_COUNT][3];",
        "",
        "extern const scale_config_t scale_default;",
    ]
    return c_comment_head(spec) + "\n".join([*lines, "", "#endif", ""])


def _value(field: str, value: int | list[int]) -> str:
    if isinstance(value, list):
        return "{" + ", ".join(str(each) for each in value) + "}"
    return f"{value}U" if field.endswith("_us") else str(value)


def source(spec: Spec) -> str:
    """Text of scale_units.c."""
    lines = ['#include "scale_units.h"', "", '#include "port_rom.h"', ""]
    lines.append("const uint16_t scale_unit_reciprocals[SCALE_UNIT_COUNT][3] PORT_ROM = {")
    table = scale.reciprocals(spec.content)
    for at, (mantissa, exponent) in enumerate(table):
        halves = f"{mantissa >> 16:#06x}U, {mantissa & 0xFFFF:#06x}U"
        lines.append(f"    {{{halves}, {exponent}U}}, /* 10 {spec.content['unit'][at]['name']} */")
    lines += ["};", "", "const scale_config_t scale_default = {"]
    fields = scale.config(content=spec.content)
    lines += [f"    .{field} = {_value(field, value)}," for field, value in fields.items()]
    return c_comment_head(spec) + "\n".join([*lines, "};", ""])
