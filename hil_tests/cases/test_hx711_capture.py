# SPDX-License-Identifier: MIT
"""A real HX711's waveform, captured with a logic analyser, through the driver's decoding."""

import os
import zipfile
from pathlib import Path

import numpy as np
import pytest

from terazi.link.generated.messages import Sample

CAPTURE = Path("hx711", "endail_pico", "hx711_80sps_nogainchange.sr")
SAMPLE_HZ = 24_000_000
CONVERSIONS, PULSES, BITS = 17, 25, 24

T2_S = 0.1e-6  # DOUT is valid so long after PD_SCK rose, HX711 datasheet p. 5
# The driver reads DOUT in the 6th cycle after PD_SCK rose (nop, nop, cbi, sei, sbic), and the pin's
# synchroniser looks up to 1.5 cycles earlier. It raises PD_SCK again 10 cycles after it rose.
DRIVER_LOOKS_S = 4.5 * 62.5e-9


@pytest.fixture(scope="module")
def waveform():
    """PD_SCK's rises and falls as (conversions, pulses) sample numbers, and DOUT's levels."""
    data = os.environ.get("TERAZI_DATA")
    if not data:
        pytest.skip("TERAZI_DATA is unset: no real HX711 capture to replay")
    with zipfile.ZipFile(Path(data) / CAPTURE) as archive:
        levels = np.frombuffer(archive.read("logic-1-1"), np.uint8)
    sck, dout = np.diff(levels.astype(np.int8) & 1), levels >> 1 & 1
    rises = np.flatnonzero(sck == 1) + 1
    falls = np.flatnonzero(sck == -1) + 1
    shape = (CONVERSIONS, PULSES)
    return rises.reshape(shape), falls.reshape(shape), dout


def counts_of(bits):
    """24 bits, the highest first, in two's complement, to counts."""
    value = bits.astype(np.int64) @ (1 << np.arange(BITS - 1, -1, -1))
    return np.where(value >= 2 ** (BITS - 1), value - 2**BITS, value)


@pytest.fixture(scope="module")
def captured_counts(waveform):
    """What the capture says, read at the end of each pulse as the datasheet has it."""
    _rises, falls, dout = waveform
    return counts_of(dout[falls[:, :BITS] - 1])


def test_the_capture_holds_seventeen_plausible_conversions(captured_counts):
    assert len(captured_counts) == CONVERSIONS
    assert abs(captured_counts.mean() - 4314) < 5
    assert 90 < captured_counts.std() < 130  # recorded with it: 109


def test_a_real_chip_holds_its_bits_while_the_driver_looks(waveform, captured_counts):
    rises, _falls, dout = waveform
    first = int(np.ceil(T2_S * SAMPLE_HZ))
    end = np.diff(rises[:, : BITS + 1], axis=1).min()  # this capture's clock is faster than ours
    assert first / SAMPLE_HZ < DRIVER_LOOKS_S
    assert first < end
    for look in range(first, end):
        assert list(counts_of(dout[rises[:, :BITS] + look])) == list(captured_counts)
        assert dout[rises[:, BITS] + look].all(), "the extra pulse reads as 1: the frame check"


@pytest.mark.board(noise_counts=0.0)
def test_the_driver_decodes_the_captured_conversions(uno, waveform, captured_counts):
    rises, _falls, _dout = waveform
    virtual = uno.truth("hand out captured conversions")
    period_s = np.diff(rises[:, 0]).mean() / SAMPLE_HZ
    uno.link.hello()
    uno.samples(4)
    last_s, period_here_s = virtual.conversions["time_s"][-1], 1 / 80
    quiet = 3  # conversions before the captured ones start

    def counts(t_s):
        place = np.round((t_s - last_s) / period_here_s).astype(int) - 1 - quiet
        inside = (place >= 0) & (place < CONVERSIONS)
        return np.where(inside, captured_counts[np.clip(place, 0, CONVERSIONS - 1)], -1)

    uno.load(counts=counts)
    told = [one.message.raw_counts for one in uno.wait(0.6) if isinstance(one.message, Sample)]
    assert [value for value in told if value not in (-1, 0)] == list(captured_counts)
    assert abs(1 / period_s - 82.02) < 0.01


@pytest.mark.board(rate_sps=82.02)
def test_the_captured_chip_s_rate_is_measured(uno, waveform):
    rises, _falls, _dout = waveform
    rate_hz = SAMPLE_HZ / np.diff(rises[:, 0]).mean()
    uno.link.hello()
    uno.wait(1.5)
    measured_hz = uno.link.status().converter_rate_hz_q16 / 65536
    assert abs(measured_hz / rate_hz - 1) < 3e-4
