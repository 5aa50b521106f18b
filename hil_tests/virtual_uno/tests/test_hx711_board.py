# SPDX-License-Identifier: GPL-3.0-or-later
"""The HX711 on the board's pins, read by a small program: signals, noise, faults, truth."""

import numpy as np
import pytest

from virtual_uno import Uno
from virtual_uno.hx711 import COUNTS_PER_GRAM, NOISE_COUNTS_80_SPS


def frames(uno):
    """(counts, DOUT after pulse 25) of every frame that the program sent."""
    data = uno.uart.read()
    data = np.frombuffer(data[: len(data) // 4 * 4], np.uint8).reshape(-1, 4).astype(np.int64)
    counts = data[:, 0] << 16 | data[:, 1] << 8 | data[:, 2]
    return np.where(counts & 0x800000, counts - (1 << 24), counts), data[:, 3]


def test_what_the_program_reads_is_what_the_part_says_it_sent(uno):
    board = uno("reader.c", noise_counts=NOISE_COUNTS_80_SPS, jitter_s=2e-6)
    board.load(grams=lambda t: 100 * np.sin(t))
    board.run(3.005)
    counts, check = frames(board)
    truth = board.conversions
    truth = truth[truth["read"]]
    assert len(counts) == len(truth) == 240
    assert (counts == truth["counts"]).all()
    assert (check == 1).all()
    stats = board.stats["hx711"]
    for name in (
        "frames_short",
        "frames_long",
        "overruns",
        "busy_pulses",
        "t1_too_short",
        "sck_high_too_short",
        "sck_high_too_long",
        "sck_low_too_short",
    ):
        assert stats[name] == 0


def test_truth_holds_the_cycle_at_which_dout_fell(uno, tmp_path, vcd_edges):
    board = uno("reader.c", rate_sps=92.0)
    with board.vcd(tmp_path / "w.vcd"):
        board.run(0.2)
    edges = np.array(vcd_edges(tmp_path / "w.vcd", "DOUT"))
    assert np.isin(board.conversions["cycle"], edges[edges[:, 1] == 0, 0]).all()
    assert np.diff(board.conversions["cycle"]) == pytest.approx(16e6 / 92.0, abs=1)


def test_rate_and_clock_error_multiply(uno):
    board = Uno(rate_sps=80.0, clock_ppm=25000)
    board.run(1.0)
    assert np.diff(board.conversions["time_s"]) == pytest.approx(1 / 82.0, abs=1e-7)


def test_jitter_is_about_the_even_grid_and_does_not_add_up():
    board = Uno(rate_sps=80.0, jitter_s=1e-5, seed=4)
    board.run(20.0)
    off_s = board.conversions["time_s"] - np.arange(1, 1 + len(board.conversions)) / 80.0
    assert off_s.std() == pytest.approx(1e-5, rel=0.1)
    assert abs(off_s).max() < 6e-5


def test_noise_is_white_and_as_large_as_asked():
    board = Uno(noise_counts=NOISE_COUNTS_80_SPS, seed=11)
    board.load(counts=5000)
    board.run(60.0)
    noise = board.conversions["counts"][4:] - 5000.0
    assert abs(noise.mean()) < 3 * NOISE_COUNTS_80_SPS / np.sqrt(len(noise))
    assert noise.std() == pytest.approx(NOISE_COUNTS_80_SPS, rel=0.05)
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.05


def test_load_is_sampled_at_the_conversions_own_instants():
    board = Uno(rate_sps=77.7)
    board.load(counts=lambda t: 1e5 * np.sin(2 * np.pi * 50 * t))
    board.run(3.0)
    truth = board.conversions[4:]
    expected = 1e5 * np.sin(2 * np.pi * 50 * truth["time_s"])
    assert abs(truth["counts"] - expected).max() <= 0.5 + 1e-3


def test_load_takes_numbers_arrays_and_both_kinds_of_functions():
    def scalar_only(t):
        return 7.0 if t > 0.5 else 3.0

    for load, at_start, at_end in [
        (12.5, 12.5, 12.5),
        ((np.array([0.0, 10.0]), 1.0), 0.625, 9.875),
        (lambda t: 10 * np.minimum(t, 1), 0.625, 9.875),
        (scalar_only, 3.0, 7.0),
        (lambda t: 4.0, 4.0, 4.0),
    ]:
        board = Uno(zero_counts=1000)
        board.load(grams=load)
        board.run(0.99)
        truth = (board.conversions["source_counts"] - 1000) / COUNTS_PER_GRAM
        assert truth[4] == pytest.approx(at_start, abs=1e-6)
        assert truth[-1] == pytest.approx(at_end, abs=1e-6)


def test_load_function_counts_seconds_from_the_reset():
    board = Uno()
    board.load(counts=lambda t: 1000 * t)
    board.run(1.0)
    board.reset()
    board.run(0.5)
    after = board.conversions[board.conversions["time_s"] > 1.0]
    assert after["source_counts"] == pytest.approx(1000 * (after["time_s"] - 1.0), abs=1e-3)


def test_a_failing_load_function_raises_where_run_was_called():
    board = Uno()
    board.load(counts=lambda t: np.asarray(t) / 0 if np.ndim(t) and t[0] > 0.5 else 0 * t)
    with pytest.raises((ZeroDivisionError, RuntimeWarning)):
        board.run(2.0)
    with pytest.raises(TypeError, match="either grams or counts"):
        board.load()
    with pytest.raises(ValueError, match="at least one value"):
        board.load(grams=(np.array([]), 10.0))


def test_power_down_by_the_program_is_seen(uno):
    board = uno("reader.c")
    board.run(0.2)
    board.poke(board.symbol("power_down"), b"\1")
    board.run(0.1)
    assert board.stats["hx711"]["power_downs"] == 1
    before = board.conversion_count
    board.run(0.1)
    assert board.conversion_count == before
    board.poke(board.symbol("power_down"), b"\0")
    board.run(0.2)
    assert board.conversions["settling"][before : before + 5].tolist() == [True] * 4 + [False]


@pytest.mark.parametrize(("gain_kept", "gain"), [(False, 128), (True, 64)])
def test_gain_after_power_down_as_either_datasheet_says(uno, gain_kept, gain):
    board = uno("reader.c", gain_kept=gain_kept)
    board.run(0.001)  # past the start-up code, which clears the variables
    board.poke(board.symbol("extra_pulses"), b"\2")
    board.run(0.2)
    assert board.conversions["gain"][-1] == 64
    board.poke(board.symbol("extra_pulses"), b"\0")
    board.poke(board.symbol("power_down"), b"\1")
    board.run(0.1)
    board.poke(board.symbol("power_down"), b"\0")
    before = board.conversion_count
    board.run(0.02)
    assert board.conversions["gain"][before] == gain


def test_external_reset_leaves_the_converter_running_and_power_on_does_not():
    board = Uno()
    board.run(0.2)
    before = board.conversion_count
    board.reset("external")
    board.run(0.105)
    assert not board.conversions["settling"][before:].any()
    before = board.conversion_count
    board.reset("power_on")
    board.run(0.1)
    assert board.conversions["settling"][before : before + 4].all()


def test_fault_dout_high_looks_as_if_nothing_were_ever_ready(uno):
    board = uno("reader.c")
    board.run(0.2)
    board.fault("dout_high")
    board.uart.discard()
    board.run(0.2)
    assert board.uart.read() == b""
    board.clear_faults()
    board.run(0.1)
    assert len(frames(board)[0]) == 8


def test_fault_dout_low_reads_zeros_and_fails_the_frame_check(uno):
    board = uno("reader.c")
    board.load(counts=-5)
    board.run(0.1)
    board.fault("dout_low")
    board.run(0.01)
    board.uart.discard()
    board.run(0.1)
    counts, check = frames(board)
    assert len(counts) > 8  # always "ready"
    assert set(counts) == {0}
    assert set(check) == {0}


def test_fault_bit_lost_shifts_one_frame(uno):
    board = uno("reader.c")
    board.load(counts=0x0F0F0F)
    board.run(0.1)
    board.uart.discard()
    board.fault("bit_lost", bit=12, frames=1)
    board.run(0.1)
    counts, check = frames(board)
    wrong = counts != 0x0F0F0F
    assert wrong.sum() == 1
    assert counts[wrong].tolist() == [0x0F0000 | 0x0F0F >> 1]  # bit 13 twice, then one behind
    assert check[wrong].tolist() == [1]  # the last bit is a one: the check cannot see it
    assert board.stats["hx711"]["frames_short"] == 1


def test_fault_bit_lost_fails_the_frame_check_of_an_even_value(uno):
    board = uno("reader.c")
    board.load(counts=0x0F0F0E)
    board.run(0.1)
    board.uart.discard()
    board.fault("bit_lost", bit=12, frames=1)
    board.run(0.1)
    counts, check = frames(board)
    first = np.flatnonzero(counts != 0x0F0F0E)[0]
    assert check[first] == 0
    # a driver that takes the low line for "ready" reads on, and the gain changes under it
    assert board.stats["hx711"]["frames_long"] == 1
    assert 64 in board.conversions["gain"]


def test_fault_late_delays_one_conversion_and_those_after_follow_it(uno):
    board = uno("reader.c")
    board.run(0.1)
    board.fault("late", seconds=0.4)
    board.run(1.0)
    gaps = np.diff(board.conversions["time_s"])
    assert (gaps > 0.0126).sum() == 1
    assert gaps.max() == pytest.approx(0.4 + 1 / 80, abs=1e-6)
    assert gaps[-1] == pytest.approx(1 / 80, abs=1e-6)


def test_fault_cable_out_reads_high_by_the_pull_up_and_starts_anew_when_back(uno):
    board = uno("reader.c")
    board.run(0.2)
    board.fault("cable_out")
    board.run(0.01)
    board.uart.discard()
    before = board.conversion_count
    board.run(0.3)
    assert board.uart.read() == b""  # pulled up: never ready
    assert board.conversion_count == before
    assert board.peek(0x29)[0] & 4  # PIND2
    board.clear_faults()
    board.run(0.1)
    assert board.conversions["settling"][before : before + 5].tolist() == [True] * 4 + [False]


def test_fault_cable_out_reads_low_without_a_pull_up():
    board = Uno()
    board.run(0.001)
    assert board.peek(0x29)[0] & 4  # DOUT is driven high until the first conversion
    board.fault("cable_out")
    board.run(0.001)
    assert not board.peek(0x29)[0] & 4


@pytest.mark.parametrize(("side", "counts"), [("high", 0x7FFFFF), ("low", -0x800000)])
def test_fault_rail_saturates(uno, side, counts):
    board = uno("reader.c")
    board.fault("rail", side=side)
    board.run(0.5)
    assert frames(board)[0][-1] == counts
    board.clear_faults()
    board.run(0.1)
    assert frames(board)[0][-1] == 0


def test_fault_noisy_line_flips_bits_now_and_then(uno):
    board = uno("reader.c", rate_sps=1000)
    board.run(0.1)
    board.uart.discard()
    board.fault("noisy_line", probability=0.01)
    board.run(2.0)
    counts, check = frames(board)
    flipped = sum(bin(int(c) & 0xFFFFFF).count("1") for c in counts)
    assert flipped == pytest.approx(0.01 * 24 * len(counts), rel=0.25)
    assert (check == 1).all()


def test_unknown_faults_and_their_details_are_refused():
    board = Uno()
    with pytest.raises(ValueError, match="no fault 'gremlin'"):
        board.fault("gremlin")
    with pytest.raises(TypeError, match="knows no duration"):
        board.fault("late", duration=3)
    with pytest.raises(ValueError, match=r"1\.\.25"):
        board.fault("bit_lost", bit=26)


def test_update_pulse_gives_an_edge_for_each_unread_conversion(uno, tmp_path, vcd_edges):
    for pulse_s, falls in [(0.0, 1), (20e-6, 8)]:
        board = uno("reader.c", update_pulse_s=pulse_s)
        board.run(0.001)
        board.poke(board.symbol("hold"), b"\1")
        with board.vcd(tmp_path / "w.vcd"):
            board.run(0.1)
        edges = vcd_edges(tmp_path / "w.vcd", "DOUT")
        assert sum(level == 0 for _, level in edges) == falls
        assert board.stats["hx711"]["conversions"] == 8


def test_driver_sees_each_conversion_once_at_ten_sps(uno):
    board = uno("reader.c", rate_sps=10.8)
    board.run(2.0)
    assert len(frames(board)[0]) == 21
    assert board.stats["hx711"]["conversions_missed"] == 0
