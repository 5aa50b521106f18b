# SPDX-License-Identifier: MIT
"""In which order the image's functions stand best: `python -m tools.measure.order`.

A CALL or JMP takes 4 bytes and reaches everything, an RCALL or RJMP takes 2 and reaches 4 KB; the
linker takes the short one where it reaches (--relax). So the order of the functions is worth some
300 bytes. This looks for a good one, by annealing from the image as it was linked last, and writes
firmware/port/order.ld. What the image does depends on no order, and a function that is not named
there stands behind those that are: the file may be old, it is then only less good.
"""

from __future__ import annotations

import math
import random
import re
import subprocess
from bisect import bisect_right
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ELF = ROOT / ".build/firmware/terazi.elf"
SCRIPT = ROOT / "firmware/port/order.ld"

REACH_BYTES = 4090  # of RCALL and RJMP: 4 KB and less a word or two
SAVES_BYTES = 2
STEPS = 150_000
SEED = 1
HOT, COLD = 2.0, 0.02  # in calls out of reach

_SECTION = re.compile(r"^ (\.text\.\S+)\s+0x([0-9a-f]+)\s+0x([0-9a-f]+) ", re.M)
_JUMP = re.compile(r"^\s+([0-9a-f]+):\t.*\tr?(?:call|jmp)\t.*0x([0-9a-f]+) <", re.M)
# Names that link-time optimisation makes up; they differ from one link to the next.
_MADE_UP = re.compile(r"\.(lto_priv|part|constprop|isra)\b.*")

HEAD = """\
/* SPDX-License-Identifier: MIT */
/* order - where functions stand in the image, so that most calls are short. Written by
 * tools/measure/order.py; do not edit. The linker's own script follows and places what is not
 * named here; what must stand at the image's beginning is named as there. */
SECTIONS
{
    .text :
    {
        KEEP(*(.vectors))
        *(.progmem.gcc*)
        . = ALIGN(2);
        *(.trampolines*)
        *(.progmem*)
        . = ALIGN(2);
"""
TAIL = """\
    }
}
INSERT BEFORE .data;
"""


def sections(linker_map: str) -> list[tuple[int, int, str]]:
    """Of the code that has a section of its own: begin, bytes, name; in the order of the image."""
    found = {
        (int(begin, 16), int(size, 16), name) for name, begin, size in _SECTION.findall(linker_map)
    }
    return sorted(each for each in found if each[0] and each[1])


def jumps(listing: str, code: list[tuple[int, int, str]]) -> list[tuple[int, int, int, int]]:
    """From one section to another: index and offset of both ends."""
    begins = [begin for begin, _, _ in code]

    def place(address: int) -> tuple[int, int] | None:
        index = bisect_right(begins, address) - 1
        offset = address - begins[index]
        return (index, offset) if index >= 0 and offset < code[index][1] else None

    found = []
    for here, there in _JUMP.findall(listing):
        source, target = place(int(here, 16)), place(int(there, 16))
        if source and target and source[0] != target[0]:
            found.append((*source, *target))
    return found


def out_of_reach(
    order: list[int], code: list[tuple[int, int, str]], edges: list[tuple[int, int, int, int]]
) -> int:
    """How many jumps must be long in this order."""
    begin, at = [0] * len(code), 0
    for index in order:
        begin[index] = at
        at += code[index][1]
    return sum(
        abs(begin[target] + there - begin[source] - here) > REACH_BYTES
        for source, here, target, there in edges
    )


def anneal(
    code: list[tuple[int, int, str]], edges: list[tuple[int, int, int, int]]
) -> tuple[list[int], int]:
    """A good order, and how many jumps are long in it."""
    rng = random.Random(SEED)
    now = best = list(range(len(code)))
    cost = least = out_of_reach(now, code, edges)
    for step in range(STEPS):
        heat = HOT * (1 - step / STEPS) + COLD
        other = now[:]
        other.insert(rng.randrange(len(code)), other.pop(rng.randrange(len(code))))
        if rng.random() < 0.3:
            a, b = rng.randrange(len(code)), rng.randrange(len(code))
            other[a], other[b] = other[b], other[a]
        tried = out_of_reach(other, code, edges)
        if tried <= cost or rng.random() < math.exp((cost - tried) / heat):
            now, cost = other, tried
            if cost < least:
                best, least = now, cost
    return best, least


def script(names: list[str]) -> str:
    """The linker script that names these sections in this order."""
    lines = [f"        KEEP(*(.init{level}))\n" for level in range(10)]
    for name in names:
        stem = _MADE_UP.sub("", name)
        is_library = stem.startswith((".text.libgcc", ".text.avr-libc"))  # whose names are whole
        line = f"        *({stem})\n" if is_library else f"        *({stem} {stem}.*)\n"
        if line not in lines:
            lines.append(line)
    return HEAD + "".join(lines) + TAIL


def main() -> None:
    """Write the script and say what it is worth."""
    code = sections(ELF.with_suffix(".map").read_text())
    listing = subprocess.run(
        ["avr-objdump", "-d", "-j", ".text", ELF], capture_output=True, text=True, check=True
    ).stdout
    edges = jumps(listing, code)
    before = out_of_reach(list(range(len(code))), code, edges)
    order, after = anneal(code, edges)
    SCRIPT.write_text(script([code[index][2] for index in order]))
    print(
        f"{len(code)} sections, {len(edges)} jumps between them; out of reach: {before} as linked,"
        f" {after} in {SCRIPT.relative_to(ROOT)}: {SAVES_BYTES * (before - after)} bytes less"
    )


if __name__ == "__main__":
    main()
