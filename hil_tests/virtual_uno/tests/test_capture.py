# SPDX-License-Identifier: GPL-3.0-or-later
"""The simulated HX711 against a logic analyser's capture of a real one.

The capture's clock edges drive the part, frame by frame from the moment at which DOUT fell, and
the two answers are compared. The capture is no part of the repository: TERAZI_DATA names its
folder.
"""

import os
import pathlib
import zipfile

import numpy as np
import pytest

from virtual_uno import Hx711

CAPTURE = "hx711/endail_pico/hx711_80sps_nogainchange.sr"
SAMPLE_NS = 1e3 / 24.0
TICKS_PER_SAMPLE = 10  # the part runs at 240 MHz, so that T2 = 24 ticks
TICKS_PER_S = 240e6


class Capture:
    """Edges in samples of 1/24 us, frames of 25 pulses."""

    def __init__(self, path):
        with zipfile.ZipFile(path) as archive:
            logic = np.frombuffer(archive.read("logic-1-1"), np.uint8).astype(np.int8)
        self.clk, self.dat = logic & 1, logic >> 1 & 1
        self.up = np.flatnonzero(np.diff(self.clk) == 1).reshape(-1, 25) + 1
        self.down = np.flatnonzero(np.diff(self.clk) == -1).reshape(-1, 25) + 1
        falls = np.flatnonzero(np.diff(self.dat) == -1) + 1
        self.ready = np.array([falls[falls < first].max() for first in self.up[:, 0]])

    def bits(self, frame):
        """The level of DAT just before each falling edge of CLK."""
        return [int(self.dat[edge - 1]) for edge in self.down[frame]]


@pytest.fixture(scope="module")
def capture():
    folder = os.environ.get("TERAZI_DATA")
    if not folder:
        pytest.skip("TERAZI_DATA is unset: no capture of a real HX711")
    path = pathlib.Path(folder) / CAPTURE
    if not path.exists():
        pytest.skip(f"{path} is missing: no capture of a real HX711")
    return Capture(path)


def counts(bits):
    word = sum(bit << (23 - i) for i, bit in enumerate(bits[:24]))
    return word - (1 << 24) if word & 0x800000 else word


@pytest.fixture(scope="module")
def answers(capture):
    """(bits, delays of DOUT's moves in ns, ready ticks) of the part under the same clock."""
    rate_sps = 24e6 / np.diff(capture.ready).mean()
    part = Hx711(TICKS_PER_S, rate_sps=rate_sps)
    for _ in range(4):  # let it settle, read by a clock of our own
        _next_ready(part)
        at = part.dout_changed_tick + 2400
        for i in range(25):
            part.sck(at + 480 * i, 1)
            part.sck(at + 480 * i + 240, 0)
    all_bits, delays_ns, ready = [], [], []
    for frame in range(len(capture.up)):
        part.set_counts(counts(capture.bits(frame)))
        _next_ready(part)
        ready.append(part.dout_changed_tick)
        shift = ready[-1] - capture.ready[frame] * TICKS_PER_SAMPLE
        bits = []
        for up, down in zip(capture.up[frame], capture.down[frame], strict=True):
            before = part.dout
            part.sck(int(up) * TICKS_PER_SAMPLE + int(shift), 1)
            part.advance(int(down) * TICKS_PER_SAMPLE + int(shift) - 1)
            bits.append(part.dout)
            if part.dout != before:
                moved = part.dout_changed_tick - shift - int(up) * TICKS_PER_SAMPLE
                delays_ns.append(moved / TICKS_PER_S * 1e9)
            part.sck(int(down) * TICKS_PER_SAMPLE + int(shift), 0)
        all_bits.append(bits)
    part.advance(ready[-1] + 100000)
    return part, all_bits, np.array(delays_ns), np.array(ready)


def _next_ready(part):
    seen = part.stats["conversions"]
    at = part.dout_changed_tick
    while part.stats["conversions"] == seen:
        at += 2400
        part.advance(at)


def test_capture_is_what_its_description_says(capture):
    assert capture.up.shape == (17, 25)
    values = [counts(capture.bits(frame)) for frame in range(17)]
    assert np.std(values, ddof=1) == pytest.approx(109, rel=0.3)


def test_part_hands_out_the_captured_bits_under_the_captured_clock(capture, answers):
    _, bits, _, _ = answers
    assert bits == [capture.bits(frame) for frame in range(17)]


def test_dout_is_high_after_pulse_25_in_both(capture, answers):
    _, bits, _, _ = answers
    for frame in range(17):
        assert bits[frame][24] == capture.bits(frame)[24] == 1


def test_dout_moves_within_100_ns_of_the_clock_in_both(capture, answers):
    _, _, delays_ns, _ = answers
    moves = np.flatnonzero(np.diff(capture.dat)) + 1
    ups = capture.up.ravel()
    real_ns = []
    for frame in range(17):
        first, last = capture.up[frame, 0], capture.up[frame, -1] + 5
        for move in moves[(moves >= first) & (moves < last)]:
            real_ns.append((move - ups[ups <= move].max()) * SAMPLE_NS)
    assert len(real_ns) == len(delays_ns) + 8  # the real line glitches four times
    assert 0 <= min(real_ns) <= max(real_ns) <= 100
    # the part takes the whole of T2: whoever reads it can read the real one
    assert max(real_ns) <= delays_ns.min() <= delays_ns.max() <= 100


def test_period_is_12_19_ms_in_both(capture, answers):
    _, _, _, ready = answers
    real_ms = np.diff(capture.ready) * SAMPLE_NS * 1e-6
    part_ms = np.diff(ready) / TICKS_PER_S * 1e3
    assert real_ms.mean() == pytest.approx(12.1917, abs=1e-3)
    assert part_ms.mean() == pytest.approx(real_ms.mean(), abs=1e-4)


def test_the_captured_clock_breaks_no_rule_that_the_part_counts(answers):
    stats = answers[0].stats
    for rule in (
        "frames_short",
        "frames_long",
        "overruns",
        "busy_pulses",
        "power_downs",
        "sck_high_too_long",
        "t1_too_short",
    ):
        assert stats[rule] == 0, rule
    # 4 or 5 samples of 1/24 us: 0.167..0.208 us, at the edge of T3 and T4 = 0.2 us
    assert 160 < stats["sck_high_min_ticks"] / TICKS_PER_S * 1e9 * 1e0 < 210
