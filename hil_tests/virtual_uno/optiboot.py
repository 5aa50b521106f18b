# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the Uno's boot loader from the source that Debian's arduino-core-avr installs.

``python -m virtual_uno.optiboot`` prints the path of the HEX file in ``.build/bench``.

The package's own ``optiboot_atmega328.hex`` cannot be used, on a real chip or here: its compiler
made 532 bytes of it, which reach past the end of the flash, and the version word lies in the
middle of its code, so that it never starts the program. Without the three LED flashes at the
start the same source fits.
"""

import os
import pathlib
import subprocess

from virtual_uno.build import BUILD
from virtual_uno.program import read_hex

SOURCE = pathlib.Path("/usr/share/arduino/hardware/arduino/avr/bootloaders/optiboot/optiboot.c")
HEX = BUILD / "optiboot_atmega328.hex"
VERSION_ADDRESS = 0x7FFE
# As in optiboot's Makefile, target atmega328, but for LED_START_FLASHES.
FLAGS = (
    "-w -Os -fno-inline-small-functions -fno-split-wide-types -mmcu=atmega328p "
    "-DF_CPU=16000000L -DBAUD_RATE=115200 -DLED_START_FLASHES=0 -nostartfiles -nostdlib "
    "-Wl,--section-start=.text=0x7e00 -Wl,--section-start=.version=0x7ffe "
    "-Wl,--relax -Wl,--gc-sections"
)


def optiboot_hex():
    """Path of the built boot loader; built if missing. FileNotFoundError names the package."""
    if HEX.exists():
        return HEX
    if not SOURCE.exists():
        raise FileNotFoundError(f"{SOURCE} is missing: install arduino-core-avr")
    BUILD.mkdir(parents=True, exist_ok=True)
    elf = BUILD / f"optiboot.{os.getpid()}.elf"
    fresh = BUILD / f"optiboot.{os.getpid()}.hex"
    try:
        subprocess.run(["avr-gcc", *FLAGS.split(), str(SOURCE), "-o", str(elf)], check=True)
        sections = ["-j", ".text", "-j", ".version", "--set-section-flags", ".version=alloc,load"]
        subprocess.run(["avr-objcopy", *sections, "-O", "ihex", str(elf), str(fresh)], check=True)
        code, version = read_hex(fresh)
        if code[0] + len(code[1]) > VERSION_ADDRESS or version[0] != VERSION_ADDRESS:
            raise ValueError(f"optiboot takes {len(code[1])} bytes; there is room for 510")
        os.replace(fresh, HEX)
    finally:
        elf.unlink(missing_ok=True)
        fresh.unlink(missing_ok=True)
    return HEX


if __name__ == "__main__":
    print(optiboot_hex())
