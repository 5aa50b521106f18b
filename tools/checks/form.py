# SPDX-License-Identifier: MIT
"""Form that a tool decides: clang-format, ruff, import-linter, and the generator's own check."""

import subprocess
import sys
from pathlib import Path

from tools.checks.files import is_generated, with_suffix

SHOWN_MAX = 20


def complaints(command: list[str], root: Path, *, whole: bool = False) -> list[str]:
    """What a tool that exits non-zero has to say, shortened."""
    done = subprocess.run(command, cwd=root, capture_output=True, text=True)
    if done.returncode == 0:
        return []
    lines = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
    if len(lines) > SHOWN_MAX and not whole:
        lines = [*lines[:SHOWN_MAX], f"... and {len(lines) - SHOWN_MAX} lines more"]
    return lines or [f"{command[0]} exited with {done.returncode}"]


def c_format(root: Path) -> list[str]:
    sources = [str(path) for path in with_suffix(root, ".c", ".h") if not is_generated(path)]
    if not sources:
        return []
    style = ("--style=file", "--fallback-style=none")
    found = complaints(["clang-format", *style, "--dry-run", "-Werror", *sources], root, whole=True)
    places = [line.split(": error:")[0] for line in found if ": error:" in line]
    files = dict.fromkeys(place.split(":")[0] for place in places)
    return [f"./dev run clang-format -i {file}" for file in files] or found


def python_format(root: Path) -> list[str]:
    command = ["ruff", "format", "--no-cache", "--check", "--output-format=concise", "."]
    return complaints(command, root)


def python_lint(root: Path) -> list[str]:
    return complaints(["ruff", "check", "--output-format=concise", "."], root)


def python_layers(root: Path) -> list[str]:
    return complaints(["lint-imports", "--no-logo", "--no-cache"], root)


def generated_stale(root: Path) -> list[str]:
    return complaints([sys.executable, "-m", "tools.gen", "--check"], root)
