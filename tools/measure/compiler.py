# SPDX-License-Identifier: MIT
"""The compiler that the budget's limits hold for."""

from __future__ import annotations

import subprocess

REFERENCE_COMPILER = "5.4"  # Debian 12 has it; newer compilers choose other code


def compiler_version() -> str:
    """Version of the avr-gcc on PATH, such as 5.4.0."""
    done = subprocess.run(["avr-gcc", "-dumpversion"], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def is_reference(version: str) -> bool:
    return version == REFERENCE_COMPILER or version.startswith(f"{REFERENCE_COMPILER}.")
