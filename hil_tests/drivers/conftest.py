# SPDX-License-Identifier: MIT
"""Drivers that the image does not call yet, or whose troubles need a program that looks closely."""

import hashlib
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from virtual_uno import Uno

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
OUT = ROOT / ".build" / "driver_tests"
FOLDERS = ("app", "drivers", "board", "port")
SHARED = ("ticks", "idle", "twi")
# As firmware/Makefile has them.
FLAGS = ["-mmcu=atmega328p", "-DF_CPU=16000000UL", "-std=gnu11", "-Os", "-g", "-flto"]
FLAGS += ["-ffunction-sections", "-fdata-sections", "-Wall", "-Wextra", "-Wconversion", "-Wshadow"]
FLAGS += ["-Werror", "-Wl,--gc-sections", "-Wl,--relax"]
FLAGS += [f"-I{ROOT}/firmware/{folder}" for folder in FOLDERS]
FLAGS += [f"-I{ROOT}/shared_c/src"]


def compiled(program: str, drivers: tuple[str, ...], options: tuple[str, ...] = ()) -> Path:
    """The program with those drivers; built where a source has changed."""
    sources = [HERE / "programs" / program]
    sources += [ROOT / "firmware" / "drivers" / f"{name}.c" for name in (*SHARED, *drivers)]
    sources.append(ROOT / "firmware" / "port" / "port_clamp.S")
    digest = hashlib.sha256(" ".join((*FLAGS, *options)).encode())
    for path in (*sources, *sorted((ROOT / "firmware").glob("*/*.h"))):
        digest.update(path.read_bytes())
    elf = OUT / f"{Path(program).stem}-{digest.hexdigest()[:12]}.elf"
    if not elf.exists():
        OUT.mkdir(parents=True, exist_ok=True)
        fresh = elf.with_suffix(f".{os.getpid()}")
        subprocess.run(["avr-gcc", *FLAGS, *options, *sources, "-o", fresh], check=True)
        fresh.replace(elf)
    return elf


class Program:
    """A board that runs it, and its variables."""

    def __init__(self, elf):
        self.board = Uno(elf)

    def number(self, name, size=2, *, signed=False, at=0):
        """A variable, or a field `at` bytes into it."""
        data = self.board.peek(self.board.symbol(name) + at, size)
        return int.from_bytes(data, "little", signed=signed)


@pytest.fixture
def program():
    """`program("motion.c", ("mpu6050",), "-DX=1")` is a board with that program."""
    if not shutil.which("avr-gcc"):
        pytest.skip("avr-gcc is not installed")
    return lambda source, drivers, *options: Program(compiled(source, drivers, options))
