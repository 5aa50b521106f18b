# SPDX-License-Identifier: MIT
"""Renders the limits and the default configuration of faults.toml."""

from __future__ import annotations

from tools.gen.spec import Spec, c_comment_head

MOVE_COUNTS = 256


def limits(content: dict) -> dict[str, int]:
    """Name -> value in the units of faults.c."""
    spike, noise = content["spike"], content["noise"]
    return {
        "NOISE_COUNTS": noise["default_counts"],
        "NOISE_LEAST": noise["least_counts"],
        "MOVE_LIMIT": noise["move_limit"],
        "NOISY": noise["loud"],
        "CALM": noise["quiet"],
        "QUIET_SHIFT": noise["quiet_shift"],
        "STIRRED": noise["stir_counts"] // MOVE_COUNTS,
        "LEAVE": spike["leave_counts"] // MOVE_COUNTS,
        "BACK": spike["back_counts"] // MOVE_COUNTS,
        "REPEATS": content["stuck"]["repeats"],
        "GOOD": content["end"]["good"],
    }


def header(spec: Spec) -> str:
    """Text of faults_limits.h."""
    lines = [
        "/* faults_limits - numbers of shared_c/spec/faults.toml; what moves are compared with is",
        " * in 256 counts. */",
        "#ifndef FAULTS_LIMITS_H",
        "#define FAULTS_LIMITS_H",
        "",
        "enum {",
        *(f"    FAULTS_{name} = {value}," for name, value in limits(spec.content).items()),
        "};",
    ]
    return c_comment_head(spec) + "\n".join([*lines, "", "#endif", ""])
