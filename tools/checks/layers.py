# SPDX-License-Identifier: MIT
"""Who may include whom in C. (Who may import whom in Python stands in pyproject.toml.)

firmware/app -> drivers -> avr-libc
     |
     +-------> shared_c        no outgoing arrows but port_*.h, which the include path chooses
"""

import re
from dataclasses import dataclass
from pathlib import Path

from tools.checks.files import text_of, with_suffix

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
CONDITION = re.compile(r"^\s*#\s*(?:if|ifdef|ifndef|elif)\b(.*)$", re.MULTILINE)

PLAIN = ("stdint.h", "stdbool.h", "stddef.h", "string.h")


@dataclass(frozen=True)
class Layer:
    """A folder, the system headers it may use and the rooms whose headers it may include."""

    folder: str
    system: tuple[str, ...]  # exact, or a folder ending in "/"
    rooms: tuple[str, ...]
    port_seam: bool = False  # may include port_*.h of whichever port the build chooses
    one_target: bool = True  # may hold conditional code for a target


LAYERS = (
    Layer("shared_c/include", PLAIN, ("shared_c/include",), one_target=False),
    Layer(
        "shared_c/src",
        (*PLAIN, "math.h"),
        ("shared_c/include", "shared_c/src", "shared_c/generated"),
        port_seam=True,
        one_target=False,
    ),
    Layer(
        "shared_c/generated",
        PLAIN,
        ("shared_c/include", "shared_c/src", "shared_c/generated"),
        port_seam=True,
        one_target=False,
    ),
    Layer(
        "shared_c/port_plain",
        (*PLAIN, "assert.h"),
        ("shared_c/port_plain", "shared_c/include", "shared_c/src"),
        port_seam=True,
    ),
    Layer(
        "firmware/port",
        (*PLAIN, "avr/", "util/"),
        ("firmware/port", "shared_c/include", "shared_c/src"),
        port_seam=True,
    ),
    Layer("firmware/board", (*PLAIN, "avr/io.h"), ("firmware/board",)),
    Layer(
        "firmware/drivers",
        (*PLAIN, "avr/", "util/"),
        ("firmware/drivers", "firmware/board"),
        port_seam=True,
    ),
    # Registers and interrupts live in the drivers; the app keeps only its words in flash and turns
    # numbers into text (ltoa; that nothing takes from the heap is a law of the image).
    Layer(
        "firmware/app",
        (*PLAIN, "stdlib.h", "avr/pgmspace.h"),
        ("firmware/app", "firmware/drivers", "shared_c/include", "shared_c/generated"),
        port_seam=True,
    ),
)


def allowed_system(layer: Layer, header: str) -> bool:
    return any(
        header == rule or (rule[-1] == "/" and header.startswith(rule)) for rule in layer.system
    )


def allowed_own(layer: Layer, header: str, rooms_of: dict[str, set[str]]) -> bool:
    if layer.port_seam and header.startswith("port_"):
        return True
    rooms = rooms_of.get(header)
    # A header that exists in no room is written by the build (a version, for example).
    return rooms is None or bool(rooms & set(layer.rooms))


def breaches(root: Path) -> list[str]:
    sources = with_suffix(root, ".c", ".h", ".S")
    rooms_of: dict[str, set[str]] = {}
    for path in sources:
        if path.suffix == ".h":
            rooms_of.setdefault(path.name, set()).add(path.parent.as_posix())
    found = []
    for path in sources:
        layer = next((each for each in LAYERS if path.parent.as_posix() == each.folder), None)
        if layer is None:
            continue
        text = text_of(root, path) or ""
        for mark, header in INCLUDE.findall(text):
            fine = (
                allowed_system(layer, header)
                if mark == "<"
                else allowed_own(layer, Path(header).name, rooms_of)
            )
            if not fine:
                found.append(f"{path}: {layer.folder} may not include {header}")
        guard = f"{path.stem.upper()}_H"
        for condition in CONDITION.findall(text):
            if not layer.one_target and condition.split("/*")[0].strip() != guard:
                found.append(f"{path}: conditional code in {layer.folder}: #if{condition}")
    return found
