# SPDX-License-Identifier: GPL-3.0-or-later
"""The serial line: times, buffers, errors, and two ends that disagree on the baud rate."""

import numpy as np
import pytest

BYTE_CYCLES = 10 * 8 * 17  # UBRR 16, U2X: 117647 baud
FE, DOR = 0x10, 0x08
BURST = bytes(range(0x55, 0x5D))


def ask(board, variables):
    """Let the program read what has come; (bytes, status flags)."""
    board.poke(board.symbol("look"), b"\1")
    board.run(0.001)
    count = variables(board, "count")
    received, status = variables(board, "received", "status", n=8)
    return bytes(received[:count]), status[:count]


def test_bytes_take_ten_bit_times_and_follow_without_a_gap(uno):
    board = uno("serial.c")
    board.run(0.01)
    data, cycles = board.uart.read_stamped()
    assert data == BURST
    assert (np.diff(cycles.astype(np.int64)) == BYTE_CYCLES).all()


def test_a_write_to_a_full_buffer_is_ignored_and_counted(uno):
    board = uno("serial.c")
    board.run(0.01)
    assert 0xEE not in board.uart.read()
    assert board.stats["tx_overwrites"] == 1
    assert board.stats["tx_bytes"] == 8


def test_waveform_has_start_data_and_stop_bits(uno, tmp_path, vcd_edges):
    board = uno("serial.c")
    with board.vcd(tmp_path / "w.vcd"):
        board.run(0.01)
    edges = vcd_edges(tmp_path / "w.vcd", "TX")
    start = edges[0][0]
    assert edges[0][1] == 0
    levels = [0, *((0x55 >> i) & 1 for i in range(8)), 1, 0]  # and the next start bit
    for i, level in enumerate(levels):
        at = start + (i + 0.5) * 136
        assert [v for cycle, v in edges if cycle <= at][-1] == level


def test_two_bytes_wait_in_the_buffer_and_one_in_the_shift_register(uno, variables):
    board = uno("serial.c")
    board.run(0.01)
    board.uart.write(b"abc")
    board.run(0.01)
    assert ask(board, variables) == (b"abc", [0, 0, 0])
    assert board.stats["rx_overruns"] == 0


def test_a_fourth_byte_overruns_and_data_overrun_is_seen(uno, variables):
    board = uno("serial.c")
    board.run(0.01)
    board.uart.write(b"abcd")
    board.run(0.01)
    received, status = ask(board, variables)
    assert received == b"abd"  # the shift register was overwritten
    assert status[0] & DOR
    assert board.stats["rx_overruns"] == 1


def test_received_bytes_are_paced_by_the_hosts_baud_rate(uno):
    board = uno("serial.c")
    board.run(0.01)
    board.uart.host_baud = 115200
    board.uart.write(b"x" * 100)
    board.run_cycles(round(50 * 160e6 / 115200))
    assert board.uart.backlog == pytest.approx(50, abs=1)


@pytest.mark.parametrize("baud", [112000, 115200, 117647, 121000])
def test_ends_within_the_tolerance_understand_each_other(uno, variables, baud):
    board = uno("serial.c")
    board.uart.host_baud = baud
    board.run(0.01)
    assert board.uart.read() == BURST
    board.uart.write(b"\x00\xff\xa5")
    board.run(0.01)
    assert ask(board, variables) == (b"\x00\xff\xa5", [0, 0, 0])
    assert board.stats["rx_framing_errors"] == board.stats["tx_framing_errors"] == 0


@pytest.mark.parametrize("baud", [9600, 57600, 108000, 125000, 230400, 1000000])
def test_ends_beyond_the_tolerance_garble_bytes_and_miss_stop_bits(uno, variables, baud):
    board = uno("serial.c")
    board.uart.host_baud = baud
    board.run(0.02)
    assert board.uart.read() != BURST or board.stats["tx_framing_errors"]
    board.uart.write(b"\x00\x00")
    board.run(0.02)
    received, _ = ask(board, variables)
    assert received != b"\x00\x00" or board.stats["rx_framing_errors"]
    assert board.stats["rx_framing_errors"] + board.stats["tx_framing_errors"] > 0


def test_framing_error_flag_travels_with_its_byte(uno, variables):
    board = uno("serial.c")
    board.run(0.01)
    board.uart.host_baud = 57600  # slow zeros look like a break
    board.uart.write(b"\x00")
    board.run(0.01)
    _, status = ask(board, variables)
    assert status[0] & FE


def test_nothing_is_received_before_the_program_enables_the_receiver(uno, variables):
    board = uno("serial.c")
    board.uart.write(b"a")
    board.run_cycles(20)  # start-up code only
    board.reset("external")
    board.run(0.01)
    assert board.stats["rx_bytes"] <= 1


def test_baud_rates_must_be_positive(uno):
    with pytest.raises(ValueError, match="not positive"):
        uno("serial.c").uart.host_baud = 0


def test_cancel_forgets_what_was_not_yet_sent(uno, variables):
    board = uno("serial.c")
    board.run(0.01)
    board.uart.write(b"abcdefgh")
    board.run_cycles(200)
    board.uart.cancel()
    board.run(0.01)
    assert ask(board, variables)[0] == b"a"  # it was on the wire already
