# SPDX-License-Identifier: MIT
"""Form that a tool decides: clang-format, ruff, import-linter, and the generator's own check."""

import subprocess
import sys
from pathlib import Path

from tools.checks.files import is_generated, with_suffix

SHOWN_MAX = 20


def complaints(command: list[str], root: Path) -> list[str]:
    """What a tool that exits non-zero has to say, shortened."""
    done = subprocess.run(command, cwd=root, capture_output=True, text=True)
    if done.returncode == 0:
        return []
    lines = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
    if len(lines) > SHOWN_MAX:
        lines = [*lines[:SHOWN_MAX], f"... and {len(lines) - SHOWN_MAX} lines more"]
    return lines or [f"{command[0]} exited with {done.returncode}"]


def c_format(root: Path) -> list[str]:
    sources = [str(path) for path in with_suffix(root, ".c", ".h") if not is_generated(path)]
    found = complaints(["clang-format", "--dry-run", "-Werror", *sources], root) if sources else []
    return [line for line in found if "error:" in line or "..." in line or "exited" in line]


def python_format(root: Path) -> list[str]:
    return complaints(["ruff", "format", "--check", "."], root)


def python_lint(root: Path) -> list[str]:
    return complaints(["ruff", "check", "--output-format=concise", "."], root)


def python_layers(root: Path) -> list[str]:
    return complaints(["lint-imports", "--no-cache"], root)


def generated_stale(root: Path) -> list[str]:
    return complaints([sys.executable, "-m", "tools.gen", "--check"], root)
