# SPDX-License-Identifier: MIT
"""What the tree itself must look like, file by file."""

import re
from pathlib import Path

from tools.checks.files import is_generated, listed, text_of

TOP = {
    *("README.md", "DESIGN.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE"),
    *("dev", "pyproject.toml", "platformio.ini", ".gitignore", ".gitattributes"),
    *(".clang-format", ".clang-tidy", ".editorconfig", "MANIFEST.in"),
    *("requirements", "firmware", "shared_c", "host", "hil_tests", "tools", ".ci"),
}
SOURCES = {".c", ".h", ".S", ".py", ".sh", ".mk"}
WITH_LICENCE_LINE = SOURCES | {".toml", ".ini", ".in", ".cfg"}
NAMES_WITH_LICENCE_LINE = {"dev", "run", "Makefile", ".clang-format", ".editorconfig"}
PRODUCTS = {".o", ".a", ".so", ".elf", ".hex", ".pyc", ".vcd", ".whl", ".png"}
COLUMNS_MAX = 100
LINES_MAX = 400
GPL_ROOM = "hil_tests/virtual_uno/"

# Put together from pieces, so that this file does not breach its own law.
REGISTRIES = re.compile(
    "|".join(("pypi" + r"\.org", "python" + "hosted", r"registry\." + "npm", "deb" + r"\.debian",
              "--index" + "-url", "--extra-" + "index", "--find" + "-links", "proxy" + r"\.golang"))
)  # fmt: skip
MACHINE_PATHS = re.compile(r"(?<![\w.$}])/(?:work|home/\w|root|opt|Users)/")
LEFT_UNDONE = re.compile(r"\b(?:" + "|".join(("TO" + "DO", "FIX" + "ME", "XX" + "X", "HA" + "CK"))
                         + r")\b")  # fmt: skip
MUTE_SKIPS = re.compile(r"pytest\.skip\(\)|mark\.(?:skip|xfail)(?:\(\))?\s*$", re.MULTILINE)


def strangers(root: Path) -> list[str]:
    tops = {path.parts[0] for path in listed(root)}
    return [f"at the top, not named in DESIGN.md: {name}" for name in sorted(tops - TOP)]


def licence_lines(root: Path) -> list[str]:
    found = []
    for path in listed(root):
        if path.suffix not in WITH_LICENCE_LINE and path.name not in NAMES_WITH_LICENCE_LINE:
            continue
        text = text_of(root, path)
        if not text:
            continue
        head = "\n".join(text.splitlines()[:2])
        wanted = "GPL-3.0-or-later" if path.as_posix().startswith(GPL_ROOM) else "MIT"
        if f"SPDX-License-Identifier: {wanted}" not in head:
            found.append(f"{path}: the first line is not 'SPDX-License-Identifier: {wanted}'")
    return found


def lengths(root: Path) -> list[str]:
    found = []
    for path in listed(root):
        if path.suffix not in SOURCES and path.name not in ("dev", "Makefile"):
            continue
        if is_generated(path):
            continue
        lines = (text_of(root, path) or "").splitlines()
        if len(lines) > LINES_MAX:
            found.append(f"{path}: {len(lines)} lines, at most {LINES_MAX}")
        found += [
            f"{path}:{number}: {len(line)} columns, at most {COLUMNS_MAX}"
            for number, line in enumerate(lines, 1)
            if len(line) > COLUMNS_MAX
        ]
    return found


def given_away(root: Path) -> list[str]:
    """Hosts, paths, products and unfinished things that no reader elsewhere can use."""
    found = [f"{path}: a build product" for path in listed(root) if path.suffix in PRODUCTS]
    rules = (
        (REGISTRIES, "names a package index"),
        (MACHINE_PATHS, "a path of one machine"),
        (LEFT_UNDONE, "left undone"),
        (MUTE_SKIPS, "skipped without a reason"),
    )
    for path in listed(root):
        text = text_of(root, path)
        if text is None:
            continue
        for pattern, meaning in rules:
            for match in pattern.finditer(text):
                number = text.count("\n", 0, match.start()) + 1
                found.append(f"{path}:{number}: {meaning}: {match.group().strip()}")
    return found
