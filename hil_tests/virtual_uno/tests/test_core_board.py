# SPDX-License-Identifier: GPL-3.0-or-later
"""The board as a whole: resets, memories, instances, programs that go wrong."""

import weakref

import numpy as np
import pytest

from virtual_uno import Uno, UnoCrashed
from virtual_uno.program import read_hex, read_program, write_hex

PORF, EXTRF, BORF, WDRF = 1, 2, 4, 8


@pytest.mark.parametrize(
    ("cause", "flags"),
    [("external", EXTRF), ("power_on", PORF), ("brown_out", BORF), ("watchdog", WDRF)],
)
def test_reset_restarts_the_program_and_says_why(uno, variables, cause, flags):
    board = uno("reader.c")
    board.run(0.01)
    assert variables(board, "reset_flags") == PORF
    board.reset(cause)
    assert board.seconds_since_reset == 0
    board.run(0.01)
    assert variables(board, "reset_flags") == flags
    assert board.stats["resets"] == 1


def test_unknown_reset_cause_is_refused(uno):
    with pytest.raises(ValueError, match="no reset cause 'sneeze'"):
        uno("reader.c").reset("sneeze")


@pytest.mark.parametrize("how", [1, 2], ids=["looping", "asleep with interrupts off"])
def test_watchdog_resets_a_program_that_hangs(uno, variables, how):
    board = uno("reader.c")
    board.run(0.1)
    cycle = board.cycle
    board.poke(board.symbol("hang"), bytes([how]))
    board.run(0.1)
    assert (board.stats["sleep_cycles"] > 200000) == (how == 2)  # most of 16 ms
    assert board.stats["watchdog_resets"] == 1
    assert variables(board, "reset_flags") == WDRF
    assert variables(board, "hang") == 0  # start-up code ran
    assert board.cycle >= cycle + 1600000  # time does not go back
    assert board.stats["hx711"]["power_downs"] == 0
    assert len(board.uart.read()) > 4 * 10  # and it weighs again


def test_power_on_scrambles_sram_and_an_external_reset_does_not():
    board = Uno(seed=3)
    sram = board.peek(0x100, 2048)
    assert len(set(sram)) > 200
    board.poke(0x400, b"kept")
    board.reset("external")
    assert board.peek(0x400, 4) == b"kept"
    board.reset("power_on")
    assert board.peek(0x400, 4) != b"kept"
    assert board.peek(0x100, 2048) != sram


def test_two_boards_in_one_process_do_not_touch_each_other(uno):
    alone = uno("reader.c", noise_counts=40.0, seed=5)
    alone.load(counts=1000)
    alone.run(0.4)
    first, second = (uno("reader.c", noise_counts=40.0, seed=5) for _ in range(2))
    first.load(counts=1000)
    second.load(counts=-99999)
    second.fault("dout_high")
    for _ in range(40):
        first.run_cycles(160000)
        second.run_cycles(160000)
    assert first.uart.read()[:100] == alone.uart.read()[:100]
    assert second.uart.read() == b""


def test_boards_are_freed(uno):
    resident = []
    for _ in range(3):
        for _ in range(40):
            board = uno("reader.c")
            board.load(grams=lambda t: t)
            board.run(0.02)
            gone = weakref.ref(board)
            del board
            assert gone() is None  # at once: no cycle of references keeps it for a collector
        with open("/proc/self/statm") as file:
            resident.append(int(file.read().split()[1]))
    # a board holds 32 KB flash and more; 40 of them kept would be over 500 pages
    assert resident[2] - resident[1] < 200


def test_a_program_that_leaves_the_flash_crashes_by_name(uno):
    board = uno("crash.c")
    with pytest.raises(UnoCrashed, match="crashed at"):
        board.run(0.1)


def test_eeprom_programming_takes_3400_us_and_half_of_it_1800(uno, tmp_path, vcd_edges, variables):
    board = uno("eeprom.c")
    with board.vcd(tmp_path / "w.vcd"):
        board.run_until(lambda: variables(board, "done") == 1, 0.1)
    edges = [cycle for cycle, _ in vcd_edges(tmp_path / "w.vcd", "SCK")]
    spans_us = (np.array(edges[1:8:2]) - edges[0:8:2]) / 16.0
    assert spans_us == pytest.approx([3400, 1800, 1800, 1800], abs=3)


def test_eeprom_modes_windows_and_refusals(uno, variables):
    board = uno("eeprom.c")
    board.run_until(lambda: variables(board, "done") == 1, 0.1)
    assert variables(board, "read_back", "erased", "written_only") == [0x5A, 0xFF, 0x03]
    assert board.eeprom.get(0x11, 2) == b"\xff\xff"  # while busy, and after EEMPE's 4 cycles
    assert variables(board, "late_master", "ready_count") == [0, 1]
    assert board.stats["eeprom_ignored"] == 2
    assert board.stats["eeprom_writes"] == 5
    board.run(0.01)
    assert variables(board, "done", "ready_count") == [2, 2]


@pytest.mark.parametrize(("cause", "cell"), [("external", 0xAB), ("power_on", 0xFF)])
def test_eeprom_write_survives_a_reset_but_not_a_power_loss(uno, variables, cause, cell):
    board = uno("eeprom.c")
    board.run_until(lambda: variables(board, "done") == 1, 0.1, step_s=1e-5)
    board.run(0.001)
    board.reset(cause)
    assert board.eeprom.get(0x20, 1) == bytes([cell])
    assert board.eeprom.get(0x10, 1) == b"\x03"


def test_twi_master_takes_bit_times_and_reports_the_datasheets_codes(
    uno, tmp_path, vcd_edges, variables
):
    from virtual_uno.core_lib import ffi, lib

    board = uno("twowire.c")
    lib.uno_twi_attach_registers(board.core, 0x68)
    lib.uno_twi_registers_set(board.core, bytes(range(256)))
    with board.vcd(tmp_path / "w.vcd"):
        board.run_until(lambda: variables(board, "done") == 1, 0.1)
    assert variables(board, "status", n=12) == [
        *[0x08, 0x20],  # START, nobody at 0x3C
        *[0x08, 0x18, 0x28, 0x28],  # START, 0x68 for writing, pointer, value
        *[0x10, 0x18, 0x28],  # repeated START, pointer
        *[0x10, 0x40, 0x50],  # repeated START, 0x68 for reading, first byte acknowledged
    ]
    assert variables(board, "data", n=2) == [0x0F, 0xC3]
    registers = ffi.new("uint8_t[256]")
    lib.uno_twi_registers_get(board.core, registers)
    assert registers[0x10] == 0xC3
    edges = vcd_edges(tmp_path / "w.vcd", "SCK")
    for (up, _), (down, _) in zip(edges[::2], edges[1::2], strict=True):
        assert 9 * 160 <= down - up < 9 * 160 + 30  # the polling loop sees it a little later
    assert board.stats["twi_starts"] == 4
    assert board.stats["twi_nacks"] == 1


def test_hex_files_round_trip_and_faulty_ones_are_named(tmp_path):
    image = bytes(range(256)) * 3 + b"\xff" * 100
    path = tmp_path / "a.hex"
    write_hex(path, image)
    assert read_hex(path) == [(0, image.rstrip(b"\xff"))]
    for number, bad in [(1, ":0"), (1, "nonsense"), (1, ":0100000000FE"), (1, ":0200000000FE")]:
        path.write_text(bad)
        with pytest.raises(ValueError, match=f"a.hex:{number}: "):
            read_hex(path)
    path.write_text(":020000040001F9\n:0100000055AA\n")
    with pytest.raises(ValueError, match="past the end of the flash"):
        read_hex(path)


def test_elf_gives_symbols_and_places(avr):
    program = read_program(avr("windows.c"))
    start, size = program.functions["deep"]
    assert program.function_at(start) == "deep"
    assert program.function_at(start + 2) == "deep+0x2"
    assert program.function_at(start + size) != f"deep+0x{size:x}"
    assert program.symbols["ticks"] >= 0x800100


def test_an_elf_for_another_machine_is_refused():
    with pytest.raises(ValueError, match="not a program for AVR"):
        read_program("/proc/self/exe")


def test_memory_outside_the_chip_is_refused():
    board = Uno()
    for call in (
        lambda: board.peek(0x8FF, 2),
        lambda: board.poke(-1, b"a"),
        lambda: board.eeprom.get(1020, 5),
        lambda: board.load_flash(0x7FFF, b"ab"),
    ):
        with pytest.raises(ValueError, match="outside the"):
            call()
    with pytest.raises(KeyError, match="no symbol"):
        board.symbol("main")
