# SPDX-License-Identifier: MIT
"""Worst stack depth of a linked AVR image, from its disassembly.

A function's own depth is what its prologue takes: one byte a ``push``, the bytes that the frame
pointer r28:r29 moves between being read from SP and written back, and two for an ``rcall .+0``
(avr-gcc's way to reserve two bytes). With -mcall-prologues it jumps into a shared run of 18 pushes,
with the frame's size in r26 and r27. A call adds two bytes of return address, a tail jump none.
The worst case is the deepest path from ``main`` plus the deepest interrupt handler, since handlers
do not nest; one that allows interrupts again, recursion, or an indirect call make the sum
unknowable, and are refused by name.
"""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

RETURN_ADDRESS_BYTES = 2
SHARED_PUSHES = 18  # of __prologue_saves__, one word each

# Newer binutils show labels within a function too (.LVL7, .Loc.1, L0^A), which begin none.
_FUNCTION = re.compile(r"^[0-9a-f]+ <(?P<name>[A-Za-z_][\w.]*)>:$")
_INSTRUCTION = re.compile(r"^\s+[0-9a-f]+:\s+(?P<op>[a-z]+)\s*(?P<args>[^;]*)(?:;.*?<(?P<to>.+)>)?")
_FRAME_MOVES = {"sbiw": 0, "subi": 0, "sbci": 8}  # instruction -> weight of its number, in bits
_SHARED = re.compile(r"^__(prologue_saves|epilogue_restores)__(\+0x(?P<offset>[0-9a-f]+))?$")
_TABLE_JUMP = "__tablejump2__"
_FRAME_SIZE = {"r26": 0, "r27": 8}  # register -> weight of what it is loaded with, in bits
_VECTOR = re.compile(r"^__vector_\d+$")


class UnboundedStack(Exception):
    """The worst depth cannot be known from the code."""


@dataclass
class Function:
    name: str
    own_bytes: int = 0
    calls: set[str] = field(default_factory=set)
    tail_jumps: set[str] = field(default_factory=set)
    indirect_call: bool = False
    enables_interrupts: bool = False


@dataclass(frozen=True)
class StackDepth:
    total_bytes: int
    main_path: tuple[str, ...]
    main_bytes: int
    interrupt_path: tuple[str, ...]
    interrupt_bytes: int


def parse_disassembly(text: str) -> dict[str, Function]:
    """Functions of ``avr-objdump -d --no-show-raw-insn`` by name."""
    functions: dict[str, Function] = {}
    function = None
    moved_bytes = None  # by how much r28:r29 has moved since it was read from SP
    frame: dict[str, int] = {}  # what r26 and r27 were loaded with last
    for line in text.splitlines():
        if start := _FUNCTION.match(line):
            function = functions.setdefault(start["name"], Function(start["name"]))
            moved_bytes = None
            continue
        instruction = _INSTRUCTION.match(line)
        if function is None or instruction is None:
            continue
        op, args = instruction["op"], instruction["args"].strip()
        shared = _SHARED.match(instruction["to"] or "")
        if shared:
            if shared[1] == "prologue_saves":
                skipped = int(shared["offset"] or "0", 16) // 2
                function.own_bytes += SHARED_PUSHES - skipped
                function.own_bytes += sum(frame[name] << at for name, at in _FRAME_SIZE.items())
        elif op == "ldi" and args.startswith(tuple(_FRAME_SIZE)):
            register, value = args.split(", ")
            frame[register] = int(value, 0)
        elif op == "in" and args == "r28, 0x3d":
            moved_bytes = 0
        elif op == "out" and args == "0x3d, r28" and moved_bytes is not None:
            function.own_bytes += moved_bytes
            moved_bytes = None
        elif op in _FRAME_MOVES and args.startswith(("r28, ", "r29, ")) and moved_bytes is not None:
            moved_bytes += int(args.split(", ")[1], 0) << _FRAME_MOVES[op]
        else:
            _note(function, op, args, instruction["to"])
    return functions


def _note(function: Function, op: str, args: str, to: str | None) -> None:
    if op == "push":
        function.own_bytes += 1
    elif op == "rcall" and args == ".+0":
        function.own_bytes += RETURN_ADDRESS_BYTES
    elif op in ("call", "rcall") and to:
        function.calls.add(to.split("+")[0])
    elif to == _TABLE_JUMP:
        return  # a switch: it comes back to this very function, and takes no room
    elif op in ("jmp", "rjmp") and to and "+" not in to and to != function.name:
        function.tail_jumps.add(to)
    elif op in ("icall", "eicall", "ijmp", "eijmp"):
        function.indirect_call = True
    elif op == "sei":
        function.enables_interrupts = True


def deepest(functions: dict[str, Function], name: str) -> tuple[int, tuple[str, ...]]:
    """Bytes and path of the deepest chain from ``name``, its return address not counted."""
    known: dict[str, tuple[int, tuple[str, ...]]] = {}

    def visit(name: str, above: tuple[str, ...]) -> tuple[int, tuple[str, ...]]:
        if name in above:
            raise UnboundedStack("recursion: " + " -> ".join((*above, name)))
        if name in known:
            return known[name]
        function = functions[name]
        if function.indirect_call:
            raise UnboundedStack(f"indirect call in {name}")
        below = [
            (visit(callee, (*above, name)), extra)
            for callees, extra in (
                (function.calls, RETURN_ADDRESS_BYTES),
                (function.tail_jumps, 0),
            )
            for callee in sorted(callees)
            if callee in functions
        ]
        depth, path = max(((b[0] + extra, b[1]) for b, extra in below), default=(0, ()))
        known[name] = (function.own_bytes + depth, (name, *path))
        return known[name]

    return visit(name, ())


def worst_stack(functions: dict[str, Function]) -> StackDepth:
    main_bytes, main_path = deepest(functions, "main")
    handlers = []
    for name in functions:
        if _VECTOR.match(name):
            depth, path = deepest(functions, name)
            nesting = [f for f in path if functions[f].enables_interrupts]
            if nesting:
                raise UnboundedStack(f"{nesting[0]} enables interrupts inside {name}")
            handlers.append((depth + RETURN_ADDRESS_BYTES, path))
    interrupt_bytes, interrupt_path = max(handlers, default=(0, ()))
    main_bytes += RETURN_ADDRESS_BYTES  # the start-up code calls main
    return StackDepth(
        main_bytes + interrupt_bytes, main_path, main_bytes, interrupt_path, interrupt_bytes
    )


def measure_stack(elf: Path) -> StackDepth:
    listing = subprocess.run(
        ["avr-objdump", "-d", "--no-show-raw-insn", str(elf)],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    return worst_stack(parse_disassembly(listing))
