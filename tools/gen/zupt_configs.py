# SPDX-License-Identifier: MIT
"""Renders the configurations of zupt.toml."""

from __future__ import annotations

from terazi.design import zupt
from tools.gen.spec import Spec, c_comment_head


def header(spec: Spec) -> str:
    """Text of zupt_configs.h."""
    lines = [
        "/* zupt_configs - the configurations of shared_c/spec/zupt.toml, one a detector. */",
        "#ifndef ZUPT_CONFIGS_H",
        "#define ZUPT_CONFIGS_H",
        "",
        '#include "zupt.h"',
        "",
        f"enum {{ ZUPT_CONFIGS_LEN = {len(spec.content['detector'])} }};",
        "",
        "/* Samples a visit. */",
        "enum {",
        *(
            f"    ZUPT_RATE_{rate['name'].upper()} = {rate['stride']},"
            for rate in spec.content["rate"]
        ),
        "};",
        "",
        "/* Detector 1 and so on, at a visit a sample. ROM */",
        "extern const zupt_config_t zupt_configs[ZUPT_CONFIGS_LEN];",
    ]
    return c_comment_head(spec) + "\n".join([*lines, "", "#endif", ""])


def source(spec: Spec) -> str:
    """Text of zupt_configs.c."""
    lines = ['#include "zupt_configs.h"', "", '#include "port_rom.h"', ""]
    lines.append("const zupt_config_t zupt_configs[ZUPT_CONFIGS_LEN] PORT_ROM = {")
    for entry in spec.content["detector"]:
        fields = zupt.config(entry, spec.content["sensor"])
        enter, leave = fields.pop("begin_squares")
        lines += [
            f"    {{   /* {entry['name']} */",
            f"        .begin_squares = {{{enter}L, {leave}L}},",
            *(f"        .{name} = {value}U," for name, value in fields.items()),
            "    },",
        ]
    return c_comment_head(spec) + "\n".join([*lines, "};", ""])
