# SPDX-License-Identifier: MIT
"""Simulated seconds a second of the virtual Uno, with the firmware asleep when idle, and polling.

The polling image is the firmware itself with each `sleep` made a `nop`: the main loop then turns
as long as there is nothing to do, which costs a simulator most.
"""

import shutil
import time
from pathlib import Path

from elftools.elf.elffile import ELFFile

from virtual_uno import Uno

SLEEP, NOP = bytes.fromhex("8895"), bytes.fromhex("0000")
RATE_SPS = 80.0
WARM_UP_S = 1.0  # simulated: boot, settling, first STATUS
MEASURED_S = 10.0  # simulated
ROUNDS = 3


def polling_image(elf: Path, target: Path) -> Path:
    """A copy of ``elf`` that never sleeps."""
    shutil.copyfile(elf, target)
    with elf.open("rb") as stream:
        text = ELFFile(stream).get_section_by_name(".text")
        start, code = text["sh_offset"], bytearray(text.data())
    places = [at for at in range(0, len(code), 2) if code[at : at + 2] == SLEEP]
    if not places:
        raise ValueError(f"{elf} holds no sleep instruction")
    for at in places:
        code[at : at + 2] = NOP
    with target.open("r+b") as stream:
        stream.seek(start)
        stream.write(code)
    return target


def realtime_factor(elf: Path) -> float:
    """The best of some rounds; what the chip sends is read, as a test would."""
    uno = Uno(str(elf), rate_sps=RATE_SPS, noise_counts=39.0, seed=1)
    uno.load(grams=500.0)
    uno.run(WARM_UP_S)
    best = 0.0
    for _ in range(ROUNDS):
        start_s = time.perf_counter()
        uno.run(MEASURED_S)
        uno.uart.read()
        best = max(best, MEASURED_S / (time.perf_counter() - start_s))
    return round(best, 1)
