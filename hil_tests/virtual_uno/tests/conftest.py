# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench is built once; tiny AVR programs are compiled as tests ask for them."""

import hashlib
import os
import pathlib
import shutil
import subprocess

import pytest

from virtual_uno.build import build

PROGRAMS = pathlib.Path(__file__).parent / "programs"
OUT = pathlib.Path(__file__).resolve().parents[3] / ".build" / "bench_tests"
FLAGS = ["-mmcu=atmega328p", "-DF_CPU=16000000UL", "-Os", "-g", "-std=gnu11", "-Wall", "-Werror"]


build()  # before any test module imports the core


@pytest.fixture(scope="session")
def avr():
    """``avr("reader.c")`` compiles that program and returns the ELF's path."""
    if not shutil.which("avr-gcc"):
        pytest.skip("avr-gcc is not installed")

    def compile_program(name):
        source = PROGRAMS / name
        digest = hashlib.sha256(source.read_bytes() + " ".join(FLAGS).encode()).hexdigest()[:12]
        elf = OUT / f"{source.stem}-{digest}.elf"
        if not elf.exists():
            OUT.mkdir(parents=True, exist_ok=True)
            fresh = elf.with_suffix(f".{os.getpid()}")
            subprocess.run(["avr-gcc", *FLAGS, str(source), "-o", str(fresh)], check=True)
            os.replace(fresh, elf)
        return elf

    return compile_program


@pytest.fixture
def uno(avr):
    """``uno("reader.c", rate_sps=80)`` is a board that runs that program."""
    from virtual_uno import Uno

    return lambda name, **how: Uno(avr(name), **how)


def _edges(path, signal):
    mark, now, edges, first = None, 0, [], True
    for line in pathlib.Path(path).read_text().splitlines():
        if line.startswith("$var"):
            _, _, _, letter, name, _ = line.split()
            mark = letter if name == signal else mark
        elif line.startswith("#"):
            now = int(line[1:])
        elif line[1:] == mark and not line.startswith("$"):
            if not first:
                edges.append((now // 625, int(line[0])))  # 625 * 100 ps a cycle
            first = False
    return edges


@pytest.fixture
def vcd_edges():
    """``vcd_edges(path, "SCK")`` lists (cycle, level) of a signal, its first level left out."""
    return _edges


@pytest.fixture
def variables():
    """``variables(uno, "a", "b", n=1)`` gives those bytes of SRAM, whole numbers or lists."""

    def peek(uno, *names, n=1):
        values = [list(uno.peek(uno.symbol(name), n)) for name in names]
        values = [value[0] if n == 1 else value for value in values]
        return values[0] if len(values) == 1 else values

    return peek


class BusAgent:
    """A board that makes transfers on its two-wire bus when told to (programs/bus_agent.c)."""

    def __init__(self, board):
        self.board = board

    def _put(self, name, *values):
        self.board.poke(self.board.symbol(name), bytes(values))

    def _get(self, name, n=1):
        return self.board.peek(self.board.symbol(name), n)

    def transfer(self, address, write=(), read=0, *, timeout_s=0.01):
        """Bytes that were read; OSError with the TWI's status where a byte is not acknowledged."""
        self._put("address", address)
        self._put("write_len", len(write))
        self._put("read_len", read)
        if write:
            self._put("buffer", *write)
        self._put("go", 1)
        self.board.run_until(lambda: self._get("go") == b"\0", timeout_s, step_s=2e-6)
        if failed := self._get("failed")[0]:
            raise OSError(failed, "the TWI reports this status")
        return self._get("buffer", read) if read else b""

    @property
    def seconds(self):
        """What the last transfer took."""
        return int.from_bytes(self._get("cycles", 2), "little") / 16e6


@pytest.fixture
def bus(uno):
    """A board with such a program."""
    agent = BusAgent(uno("bus_agent.c"))
    agent.board.run(1e-4)
    return agent
