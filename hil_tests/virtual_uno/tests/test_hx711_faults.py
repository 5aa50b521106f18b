# SPDX-License-Identifier: GPL-3.0-or-later
"""What the HX711 does when its clock, its power, its pulses or its insides fail."""

import numpy as np
import pytest

from virtual_uno.hx711 import NOISE_COUNTS_80_SPS


def frames(uno):
    """(counts, DOUT after pulse 25) of every frame that the program sent."""
    data = uno.uart.read()
    data = np.frombuffer(data[: len(data) // 4 * 4], np.uint8).reshape(-1, 4).astype(np.int64)
    counts = data[:, 0] << 16 | data[:, 1] << 8 | data[:, 2]
    return np.where(counts & 0x800000, counts - (1 << 24), counts), data[:, 3]


def test_fault_frozen_repeats_one_count_and_goes_on_converting(uno):
    board = uno("reader.c", noise_counts=NOISE_COUNTS_80_SPS)
    board.run(0.3)
    board.fault("frozen")
    board.uart.discard()
    board.run(0.5)
    counts, check = frames(board)
    assert len(counts) >= 39
    assert len(set(counts[1:])) == 1
    assert (check == 1).all()
    board.clear_faults()
    board.uart.discard()
    board.run(0.5)
    assert len(set(frames(board)[0])) > 20


def test_fault_noise_comes_on_top(uno):
    board = uno("reader.c", noise_counts=30.0)
    board.run(0.1)
    board.fault("noise", counts=40_000.0)
    board.uart.discard()
    board.run(8.0)
    assert frames(board)[0].std() == pytest.approx(40_000, rel=0.1)


@pytest.mark.parametrize("factor", [3.0, 0.4, 1.1])
def test_fault_rate_holds_from_the_conversion_under_way(uno, factor):
    board = uno("reader.c")
    board.run(0.3)
    before = board.conversion_count
    board.fault("rate", factor=factor)
    board.run(0.5)
    assert np.diff(board.conversions["time_s"][before - 1 :])[1:] == pytest.approx(
        1 / 80 / factor, abs=1e-6
    )
    board.clear_faults()
    board.run(0.5)
    assert np.diff(board.conversions["time_s"])[-5:] == pytest.approx(1 / 80, abs=1e-6)


def test_fault_glitch_starts_the_part_anew_once(uno):
    board = uno("reader.c")
    board.run(0.305)
    before = board.conversion_count
    at_s = board.seconds
    board.fault("glitch")
    board.run(0.2)
    conversions = board.conversions[before:]
    assert conversions["settling"][:6].tolist() == [True] * 4 + [False] * 2
    assert conversions["time_s"][0] == pytest.approx(at_s + 1 / 80, abs=1e-6)


def test_fault_conversion_lost_leaves_a_gap_of_whole_periods(uno):
    board = uno("reader.c")
    board.run(0.3)
    board.fault("conversion_lost", count=2)
    board.run(0.2)
    gaps = np.diff(board.conversions["time_s"])
    assert sorted(np.round(gaps * 80, 6).tolist())[-2:] == [1.0, 3.0]


def test_fault_stretched_makes_the_rest_of_a_frame_ones(uno):
    """An interrupt in mid-frame that holds PD_SCK high: the spikes of 2^k - 1 that users report."""
    board = uno("reader.c")
    board.load(counts=0)
    board.run(0.3)
    board.uart.discard()
    board.fault("stretched", bit=12, frames=1)
    board.run(0.1)
    counts, check = frames(board)
    assert counts[np.flatnonzero(counts)[0]] == (1 << 13) - 1
    assert check[np.flatnonzero(counts)[0]] == 1, "the frame check cannot see it"
    assert board.stats["hx711"]["power_downs"] == 1
