# SPDX-License-Identifier: MIT
"""The pins say what the lists say, and nothing about where packages come from."""

import re
import tomllib
from pathlib import Path

NAME = re.compile(r"^([A-Za-z0-9][A-Za-z0-9._-]*)(.*)$")
PIN = re.compile(r"^[a-z0-9][a-z0-9._-]*==[^\s;]+( ; .+)?$")


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def names_in(root: Path, list_name: str) -> set[str]:
    """Names in a .in file, those of the files that it takes in too."""
    names: set[str] = set()
    for line in (root / "requirements" / list_name).read_text(encoding="utf-8").splitlines():
        line = line.split("#")[0].strip()
        if line.startswith("-r "):
            names |= names_in(root, line[3:].strip())
        elif match := NAME.match(line):
            names.add(normal(match.group(1)))
    return names


def breaches(root: Path) -> list[str]:
    found = []
    for stem in ("runtime", "dev"):
        lines = (root / f"requirements/{stem}.txt").read_text(encoding="utf-8").splitlines()
        pins = [line for line in lines if line.strip()]
        found += [f"{stem}.txt: not a plain pin: {pin}" for pin in pins if not PIN.match(pin)]
        pinned = {normal(pin.split("==")[0]) for pin in pins}
        missing = names_in(root, f"{stem}.in") - pinned
        found += [f"{stem}.txt: {name} of {stem}.in is not pinned" for name in sorted(missing)]
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *project.get("optional-dependencies", {}).get("all", [])]
    needed = {normal(NAME.match(each).group(1)) for each in wanted}
    listed = names_in(root, "runtime.in")
    found += [f"runtime.in lacks {name} of pyproject.toml" for name in sorted(needed - listed)]
    found += [f"pyproject.toml lacks {name} of runtime.in" for name in sorted(listed - needed)]
    return found
