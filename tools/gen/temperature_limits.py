# SPDX-License-Identifier: MIT
"""Renders the limits of temperature.toml."""

from __future__ import annotations

from tools.gen.spec import Spec, c_comment_head


def header(spec: Spec) -> str:
    """Text of temperature_limits.h."""
    reach, smoothing = spec.content["range"], spec.content["smoothing"]
    values = {
        "LOWEST_CENTI": reach["lowest_centi"],
        "HIGHEST_CENTI": reach["highest_centi"],
        "SMOOTHING_SHIFT": smoothing["shift"],
        "STEP_MAX_CENTI": smoothing["step_max_centi"],
        "SPAN_MAX_PPM_PER_K_Q4": spec.content["limits"]["span_max_ppm_per_k"] * 16,
    }
    lines = [
        "/* temperature_limits - the numbers of shared_c/spec/temperature.toml. */",
        "#ifndef TEMPERATURE_LIMITS_H",
        "#define TEMPERATURE_LIMITS_H",
        "",
        "enum {",
        *(f"    TEMPERATURE_{name} = {value}," for name, value in values.items()),
        "};",
    ]
    return c_comment_head(spec) + "\n".join([*lines, "", "#endif", ""])
