# SPDX-License-Identifier: MIT
"""Renders the configurations and gains of rest.toml."""

from __future__ import annotations

from terazi.design import rest
from tools.gen.spec import Spec, c_comment_head

UNSIGNED = ("still_rounds", "gain_len")
UNSIGNED_LONG = ("gravity2_min", "gravity2_max")


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
        "/* 1, 1/2, 1/3 ... in Q15: the mean of all blocks. ROM */",
        "extern const uint16_t rest_gain_q15[REST_GAIN_LEN_MAX];",
        "",
        *(f"extern const rest_config_t rest_{rate['name']};" for rate in spec.content["rate"]),
    ]
    return c_comment_head(spec) + "\n".join([*lines, "", "#endif", ""])


def _literal(field: str, value: int) -> str:
    suffix = "U" if field in UNSIGNED else "UL" if field in UNSIGNED_LONG else ""
    return f"    .{field} = {value}{suffix},"


def source(spec: Spec) -> str:
    """Text of rest_configs.c."""
    gains = rest.gains_q15()
    lines = ['#include "rest_configs.h"', "", '#include "port_rom.h"', ""]
    lines += [
        "const uint16_t rest_gain_q15[REST_GAIN_LEN_MAX] PORT_ROM = {",
        *(
            "    " + " ".join(f"{gain}U," for gain in gains[at : at + 8])
            for at in range(0, len(gains), 8)
        ),
        "};",
    ]
    tables = {name: spec.content[name] for name in ("limits", "times", "sensor")}
    for rate in spec.content["rate"]:
        fields = rest.config(rate["rate_hz"], **tables)
        lines += [
            "",
            f"/* {rate['rate_hz']} Hz */",
            f"const rest_config_t rest_{rate['name']} = {{",
            *(_literal(name, value) for name, value in fields.items()),
            "};",
        ]
    return c_comment_head(spec) + "\n".join([*lines, ""])
