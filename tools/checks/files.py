# SPDX-License-Identifier: MIT
"""Which files the laws look at: everything that is or would be committed."""

import subprocess
from pathlib import Path

IGNORED = {".git", ".venv", ".build", "__pycache__", "dist"}


def listed(root: Path) -> list[Path]:
    """Every file of the tree that git does not ignore, relative to ``root``, sorted."""
    if not (root / ".git").exists():  # a tarball, or a test's little tree
        every = (path.relative_to(root) for path in root.rglob("*") if path.is_file())
        return sorted(path for path in every if not IGNORED & set(path.parts))
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(command, cwd=root, check=True, capture_output=True, text=True).stdout
    paths = {Path(name) for name in names.split("\0") if name}
    return sorted(path for path in paths if (root / path).is_file())


def with_suffix(root: Path, *suffixes: str) -> list[Path]:
    return [path for path in listed(root) if path.suffix in suffixes]


def is_generated(path: Path) -> bool:
    return "generated" in path.parts


def text_of(root: Path, path: Path) -> str | None:
    """The file's text; None if it is not text."""
    try:
        return (root / path).read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return None
