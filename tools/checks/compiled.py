# SPDX-License-Identifier: MIT
"""What compilers and the linked image say: warnings, and routines that must not be there."""

import re
import subprocess
import tempfile
from pathlib import Path

HOST_FLAGS = (
    *("-std=c11", "-O2", "-fno-wrapv", "-ffp-contract=off", "-fanalyzer", "-Werror"),
    *("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wdouble-promotion", "-Wvla"),
)
SHARED_FOLDERS = ("src", "generated", "port_plain")
IMAGE = Path(".build/firmware/terazi.elf")

HEAP_AND_STDIO = re.compile(r"^(malloc|calloc|realloc|free|v?s?n?printf|vfprintf|v?sn?scanf)$")
FLOAT = re.compile(r"^__(add|sub|mul|div|neg|cmp|fix|fixuns|float|floatun)(sf|df|sfsi|unssfsi|sisf)"
                   r"\w*$|^__(addsf3x|mulsf3x|divsf3x|fp_\w+)$")  # fmt: skip
DIVIDE = re.compile(r"^__(u?div|u?mod|u?divmod)(qi|hi|si|psi|di)\w*$")


def host_warnings(root: Path) -> list[str]:
    """shared_c under the host's compiler with the analyser, every warning an error."""
    shared = root / "shared_c"
    includes = [f"-I{shared / folder}" for folder in ("include", *SHARED_FOLDERS)]
    found = []
    with tempfile.TemporaryDirectory() as scratch:
        for folder in SHARED_FOLDERS:
            for source in sorted((shared / folder).glob("*.c")):
                command = ["gcc", *HOST_FLAGS, *includes, "-c", str(source), "-o", f"{scratch}/o"]
                done = subprocess.run(command, capture_output=True, text=True)
                if done.returncode != 0:
                    errors = [line for line in done.stderr.splitlines() if "error:" in line]
                    found += errors or done.stderr.splitlines() or [f"{source}: gcc failed"]
    return found


def names_in(image: Path, *options: str) -> list[str]:
    listing = subprocess.run(
        ["avr-nm", *options, str(image)], check=True, capture_output=True, text=True
    )
    return [line.split()[-1] for line in listing.stdout.splitlines() if line.strip()]


def forbidden_names(names: list[str], *patterns: re.Pattern[str]) -> list[str]:
    return sorted({name for name in names if any(pattern.match(name) for pattern in patterns)})


def image_laws(root: Path) -> list[str]:
    """No heap, no stdio, no float in the image; no software divide in the objects of shared_c."""
    image = root / IMAGE
    if not image.exists():
        return [f"{IMAGE} is not built"]
    found = [
        f"{IMAGE} holds {name}" for name in forbidden_names(names_in(image), HEAP_AND_STDIO, FLOAT)
    ]
    sources = {path.stem for path in (root / "shared_c/src").glob("*.c")}
    seen = set()
    for item in sorted(image.parent.rglob("*.o")):
        module = item.name.split(".")[0]  # fir.o or fir.c.o
        if module in sources:
            seen.add(module)
            calls = forbidden_names(names_in(item, "--undefined-only"), FLOAT, DIVIDE)
            found += [f"{item.name} calls {name}" for name in calls]
    found += [f"no object of {module} beside the image" for module in sorted(sources - seen)]
    return found
