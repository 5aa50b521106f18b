# SPDX-License-Identifier: MIT
"""Renders the ROM tables of fir.toml and weight_kf.toml."""

from __future__ import annotations

from terazi.design import specs
from tools.gen.spec import Spec, c_comment_head


def _rows(values: list[int], per_row: int = 8) -> list[str]:
    return [
        "    " + " ".join(f"{value}," for value in values[at : at + per_row])
        for at in range(0, len(values), per_row)
    ]


def fir_header(spec: Spec) -> str:
    """Text of fir_designs.h."""
    designs = spec.content["design"]
    width = max(len(design["name"]) for design in designs)
    lines = [
        "/* fir_designs - the coefficients of shared_c/spec/fir.toml, in ROM. */",
        "#ifndef FIR_DESIGNS_H",
        "#define FIR_DESIGNS_H",
        "",
        '#include "fir.h"',
        "",
        "/* Indices as in HELLO.fir_design. */",
        "enum {",
        *(
            f"    FIR_DESIGN_{design['name'].upper():<{width}} = {at},"
            for at, design in enumerate(designs)
        ),
        "};",
        f"enum {{ FIR_DESIGNS = {len(designs)} }};",
        "",
    ]
    for design in designs:
        lines += [f"/* {design['summary']} */", f"extern const fir_config_t fir_{design['name']};"]
    lines += [
        "",
        "/* All of them by index; whoever uses this links every design. */",
        "extern const fir_config_t *const fir_designs[FIR_DESIGNS];",
    ]
    return c_comment_head(spec) + "\n".join([*lines, "", "#endif", ""])


def fir_source(spec: Spec) -> str:
    """Text of fir_designs.c."""
    lines = ['#include "fir_designs.h"', "", '#include "port_rom.h"', ""]
    for design in spec.content["design"]:
        name = design["name"]
        taps = specs.fir_taps_q15(name).tolist()
        half = taps[: (len(taps) + 1) // 2]
        lines += [
            f"/* all {len(taps)} sum to {sum(taps)}, their magnitudes to {sum(map(abs, taps))} */",
            f"static const int16_t {name}_half_q15[{len(half)}] PORT_ROM = {{",
            *_rows(half),
            "};",
            f"const fir_config_t fir_{name} = {{ {name}_half_q15, {len(taps)}, false }};",
            "",
        ]
    lines += [
        "const fir_config_t *const fir_designs[FIR_DESIGNS] = {",
        *(f"    &fir_{design['name']}," for design in spec.content["design"]),
        "};",
        "",
    ]
    return c_comment_head(spec) + "\n".join(lines)


def kf_header(spec: Spec) -> str:
    """Text of weight_kf_gains.h."""
    schedules = spec.content["schedule"]
    width = max(len(schedule["name"]) for schedule in schedules)
    lines = [
        "/* weight_kf_gains - the gain schedules of shared_c/spec/weight_kf.toml, in ROM. */",
        "#ifndef WEIGHT_KF_GAINS_H",
        "#define WEIGHT_KF_GAINS_H",
        "",
        '#include "weight_kf.h"',
        "",
        "/* Indices as in HELLO.kf_schedule. */",
        "enum {",
        *(
            f"    WEIGHT_KF_SCHEDULE_{schedule['name'].upper():<{width}} = {at},"
            for at, schedule in enumerate(schedules)
        ),
        "};",
        "",
    ]
    for schedule in schedules:
        lines += [
            f"/* {schedule['summary']} */",
            f"extern const weight_kf_config_t weight_kf_{schedule['name']};",
        ]
    return c_comment_head(spec) + "\n".join([*lines, "", "#endif", ""])


def kf_source(spec: Spec) -> str:
    """Text of weight_kf_gains.c."""
    lines = ['#include "weight_kf_gains.h"', "", '#include "port_rom.h"', ""]
    for schedule in spec.content["schedule"]:
        name = schedule["name"]
        gains = specs.weight_kf_gains_q15(name)
        lines += [
            f"static const uint16_t {name}_gain_q15[{len(gains)}] PORT_ROM = {{",
            *(row.replace(",", "U,") for row in _rows(gains)),
            "};",
            f"const weight_kf_config_t weight_kf_{name} = {{ {name}_gain_q15, {len(gains)} }};",
            "",
        ]
    return c_comment_head(spec) + "\n".join(lines)


def kf_adaptive_header(spec: Spec) -> str:
    """Text of weight_kf_adaptive_variants.h."""
    variants = spec.content["variant"]
    lines = [
        "/* weight_kf_adaptive_variants - shared_c/spec/weight_kf_adaptive.toml as constants. */",
        "#ifndef WEIGHT_KF_ADAPTIVE_VARIANTS_H",
        "#define WEIGHT_KF_ADAPTIVE_VARIANTS_H",
        "",
        '#include "weight_kf_adaptive.h"',
        "",
        "/* [law]: what the source turns into shifts. */",
        "enum {",
        *(
            f"    WEIGHT_KF_ADAPTIVE_{name.upper()} = {value},"
            for name, value in spec.content["law"].items()
        ),
        "};",
        "",
        "enum {",
        *(
            f"    WEIGHT_KF_ADAPTIVE_VARIANT_{variant['name'].upper()} = {at},"
            for at, variant in enumerate(variants)
        ),
        "};",
        "",
    ]
    for variant in variants:
        name = variant["name"]
        lines += [
            f"/* {variant['summary']} */",
            f"extern const weight_kf_adaptive_config_t weight_kf_adaptive_{name};",
        ]
    return c_comment_head(spec) + "\n".join([*lines, "", "#endif", ""])


def kf_adaptive_source(spec: Spec) -> str:
    """Text of weight_kf_adaptive_variants.c."""
    lines = ['#include "weight_kf_adaptive_variants.h"', ""]
    for variant in spec.content["variant"]:
        name = variant["name"]
        lines += [
            f"const weight_kf_adaptive_config_t weight_kf_adaptive_{name} = {{",
            *(
                f"    .{field} = {value}U,"
                for field, value in specs.weight_kf_adaptive_config(name).items()
            ),
            "};",
            "",
        ]
    return c_comment_head(spec) + "\n".join(lines)
