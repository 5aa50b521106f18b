# SPDX-License-Identifier: MIT
"""Renders the configurations of rest.toml."""

from __future__ import annotations

from terazi.design import rest
from tools.gen.spec import Spec, c_comment_head

UNSIGNED = ("still_rounds", "gain_len", "gravity2_min", "gravity2_max")


def header(spec: Spec) -> str:
    """Text of rest_configs.h."""
    lines = [
        "/* rest_configs - the configurations of shared_c/spec/rest.toml, one a rate. */",
        "#ifndef REST_CONFIGS_H",
        "#define REST_CONFIGS_H",
        "",
        '#include "rest.h"',
        "",
        "enum {",
        *(
            f"    REST_RATE_{rate['name'].upper()} = {at},"
            for at, rate in enumerate(spec.content["rate"])
        ),
        "};",
        "",
        "/* ROM: to be copied. */",
        *(f"extern const rest_config_t rest_{rate['name']};" for rate in spec.content["rate"]),
    ]
    return c_comment_head(spec) + "\n".join([*lines, "", "#endif", ""])


def _literal(field: str, value: int | list[list[int]]) -> str:
    if isinstance(value, list):
        rows = ", ".join(f"{{{', '.join(map(str, row))}}}" for row in value)
        return f"    .{field} = {{{rows}}},"
    return f"    .{field} = {value}{'U' if field in UNSIGNED else ''},"


def source(spec: Spec) -> str:
    """Text of rest_configs.c."""
    lines = ['#include "rest_configs.h"', "", '#include "port_rom.h"']
    tables = {name: spec.content[name] for name in ("limits", "times", "sensor")}
    for rate in spec.content["rate"]:
        fields = rest.config(rate["rate_hz"], **tables)
        lines += [
            "",
            f"/* {rate['rate_hz']} Hz */",
            f"const rest_config_t rest_{rate['name']} PORT_ROM = {{",
            *(_literal(name, value) for name, value in rest.as_c(fields).items()),
            "};",
        ]
    return c_comment_head(spec) + "\n".join([*lines, ""])
