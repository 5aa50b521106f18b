# SPDX-License-Identifier: MIT
"""Renders the configurations of mahony.toml."""

from __future__ import annotations

from terazi.design import mahony
from tools.gen.spec import Spec, c_comment_head


def header(spec: Spec) -> str:
    """Text of mahony_configs.h."""
    lines = [
        "/* mahony_configs - the configurations of shared_c/spec/mahony.toml. */",
        "#ifndef MAHONY_CONFIGS_H",
        "#define MAHONY_CONFIGS_H",
        "",
        '#include "mahony.h"',
        "",
        "enum {",
        *(
            f"    MAHONY_CONFIG_{entry['name'].upper()} = {at},"
            for at, entry in enumerate(spec.content["config"])
        ),
        "};",
        "",
        *(
            f"extern const mahony_modes_config_t mahony_{entry['name']};"
            for entry in spec.content["config"]
        ),
    ]
    return c_comment_head(spec) + "\n".join([*lines, "", "#endif", ""])


def source(spec: Spec) -> str:
    """Text of mahony_configs.c."""
    lines = ['#include "mahony_configs.h"', "", '#include "port_rom.h"']
    tables = {name: spec.content[name] for name in mahony.TABLES}
    for entry in spec.content["config"]:
        mode = entry.get("mode", "second_order")
        usual = mahony.config(entry["rate_hz"], mode, **tables)
        modes = {name: usual.pop(name) for name in mahony.MODE_FIELDS}
        lines += [
            "",
            f"/* {entry['rate_hz']} Hz, {mode.replace('_', ' ')} */",
            f"const mahony_modes_config_t mahony_{entry['name']} PORT_ROM = {{",
            "    .usual = {",
            *(f"        .{name} = {value}U," for name, value in usual.items()),
            "    },",
            *(f"    .{name} = {value}U," for name, value in modes.items()),
            "};",
        ]
    return c_comment_head(spec) + "\n".join([*lines, ""])
