# SPDX-License-Identifier: MIT
"""Renders the limits and the default configuration of faults.toml."""

from __future__ import annotations

from tools.gen.spec import Spec, c_comment_head


def limits(content: dict) -> dict[str, int]:
    """Name -> value in the units of faults.c."""
    spike, noise = content["spike"], content["noise"]
    shift = noise["move_shift"]
    return {
        "MOVE_SHIFT": shift,
        "MOVE_LIMIT": noise["move_limit"],
        "NOISE_LIMIT": noise["rms_counts"] * noise["passes"] >> shift,
        "NOISY_RISE": noise["rise"],
        "NOISY_FALL": noise["fall"],
        "NOISY_FULL": noise["full"],
        "LEAVE": spike["leave_counts"] >> shift,
        "BACK": spike["back_counts"] >> shift,
        "WITHIN": spike["within"],
        "REPEATS": content["stuck"]["repeats"],
        "GOOD": content["end"]["good"],
    }


def header(spec: Spec) -> str:
    """Text of faults_limits.h."""
    lines = [
        "/* faults_limits - the numbers of shared_c/spec/faults.toml; moves and what is compared with",
        " * them are in 2^MOVE_SHIFT counts. */",
        "#ifndef FAULTS_LIMITS_H",
        "#define FAULTS_LIMITS_H",
        "",
        "enum {",
        *(f"    FAULTS_{name} = {value}," for name, value in limits(spec.content).items()),
        "};",
    ]
    return c_comment_head(spec) + "\n".join([*lines, "", "#endif", ""])
