# SPDX-License-Identifier: MIT
"""Flash and static RAM of a linked AVR image, as avr-size sees them."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

# Section -> where it takes room. `.data` takes both: its initial values lie in flash.
FLASH_SECTIONS = frozenset({".text", ".data", ".bootloader"})
RAM_SECTIONS = frozenset({".data", ".bss", ".noinit"})


@dataclass(frozen=True)
class Sizes:
    flash_bytes: int
    ram_static_bytes: int


def parse_sections(avr_size_text: str) -> dict[str, int]:
    """Sections and their bytes from ``avr-size -A -d``."""
    sections = {}
    for line in avr_size_text.splitlines():
        words = line.split()
        if len(words) == 3 and words[0].startswith("."):
            sections[words[0]] = int(words[1])
    return sections


def measure_sizes(elf: Path) -> Sizes:
    listing = subprocess.run(
        ["avr-size", "-A", "-d", str(elf)], capture_output=True, text=True, check=True
    ).stdout
    sections = parse_sections(listing)
    return Sizes(
        flash_bytes=sum(n for name, n in sections.items() if name in FLASH_SECTIONS),
        ram_static_bytes=sum(n for name, n in sections.items() if name in RAM_SECTIONS),
    )
