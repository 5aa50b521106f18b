# SPDX-License-Identifier: MIT
"""Designs to a wish: what the quantised coefficients do, by every method and at any rate."""

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import get_window

from terazi.cshared import Fir, fir_block
from terazi.design import equiripple, fir, lowpass, notch, windows
from terazi.design.lowpass import METHODS, Wish

RATE_HZ = 91.7  # an HX711 that should give 80
methods = st.sampled_from(METHODS)


@pytest.mark.parametrize("taps", [15, 32, 51, 64])
@pytest.mark.parametrize("name", ["rectangular", "hamming"])
def test_windows_are_those_of_scipy(name, taps):
    known = get_window("boxcar" if name == "rectangular" else name, taps, fftbins=False)
    assert np.allclose(windows.window(name, taps), known, atol=1e-12)


@pytest.mark.parametrize("taps", [15, 32, 51, 64])
@pytest.mark.parametrize("name", ["hann", "blackman"])
def test_windows_that_end_in_zero_waste_no_coefficient_on_it(name, taps):
    known = get_window(name, taps + 2, fftbins=False)
    assert known[0] == pytest.approx(0, abs=1e-12)
    assert np.allclose(windows.window(name, taps), known[1:-1], atol=1e-12)


@given(method=methods, taps=st.integers(8, 64), rate_hz=st.floats(10, 1000))
def test_every_design_is_one_that_the_filter_takes(method, taps, rate_hz):
    made = lowpass.design(Wish(method, rate_hz, taps))
    assert made.taps_q15.sum() == 32768
    assert np.array_equal(made.taps_q15, made.taps_q15[::-1])
    loaded = Fir(made.taps_q15.tolist(), 4321)
    assert loaded.block([4321] * 9).tolist() == [4321] * 9  # a weight passes unchanged
    assert loaded.delay_samples / rate_hz == pytest.approx(made.figures.delay_s)


@given(
    method=methods,
    rate_hz=st.floats(75, 99),
    belt_hz=st.floats(8, 18),
    taps=st.sampled_from([31, 32, 51, 64]),
)
def test_a_notch_lies_where_mains_and_belt_arrive_at_the_measured_rate(
    method, rate_hz, belt_hz, taps
):
    made = lowpass.design(Wish(method, rate_hz, taps, notches_hz=(50.0, belt_hz)))
    assert max(made.figures.notches_db.values()) <= -60
    folded = notch.folded_hz([50.0, belt_hz], rate_hz)
    assert fir.magnitude_db(made.taps_q15, folded, rate_hz).max() <= -60
    assert made.taps_q15.sum() == 32768


def test_hum_that_folds_is_gone_from_what_the_chip_would_give():
    """In the time domain, through the C: a weight under a generator's hum, 91.7 SPS."""
    n = np.arange(600)
    hum = 20_000 * np.sin(2 * np.pi * 51.5 * n / RATE_HZ + 0.3)
    samples = np.rint(429_550 + hum).astype(np.int32)
    plain = lowpass.design(Wish("rectangular", RATE_HZ, 33))
    notched = lowpass.design(Wish("rectangular", RATE_HZ, 33, notches_hz=(51.5,)))
    left = [
        np.abs(fir_block(samples, each.taps_q15.tolist())[100:] - 429_550).max()
        for each in (plain, notched)
    ]
    assert left[0] > 200
    assert left[1] <= 3


def test_folding_is_what_sampling_does():
    n = np.arange(64)
    for hz in (50.0, 60.0, 13.7, 137.3, 183.4):
        folded = notch.folded_hz(hz, RATE_HZ)
        assert 0 <= folded <= RATE_HZ / 2
        assert np.allclose(
            np.cos(2 * np.pi * hz * n / RATE_HZ), np.cos(2 * np.pi * folded * n / RATE_HZ)
        )


def test_quantising_is_told_apart_from_designing():
    figures = lowpass.design(Wish("equiripple", RATE_HZ, 64, stop_from_hz=8.0)).figures
    assert figures.stop_max_db_before < -100
    assert -90 < figures.stop_max_db < -70


def test_a_wish_that_is_not_met_is_named_and_one_that_is_met_is_not():
    wish = Wish("hamming", 80.0, 32, stop_from_hz=8.0, stop_max_db=-60.0)
    (miss,) = lowpass.design(wish).figures.misses
    assert "stop band from 8 Hz" in miss
    wish = Wish("equiripple", 80.0, 32, stop_from_hz=8.0, stop_max_db=-60.0)
    assert lowpass.design(wish).figures.misses == ()


def test_equiripple_has_the_deepest_stop_band_and_the_rectangle_the_least_noise():
    made = {
        each: lowpass.design(Wish(each, 80.0, 32, stop_from_hz=7.5)).figures for each in METHODS
    }
    assert min(made, key=lambda each: made[each].stop_max_db) == "equiripple"
    assert min(made, key=lambda each: made[each].noise_gain) == "rectangular"
    assert made["rectangular"].noise_gain == pytest.approx(1 / np.sqrt(32), rel=1e-4)


@pytest.mark.parametrize("method", METHODS)
def test_a_pass_band_passes(method):
    figures = lowpass.design(Wish(method, 80.0, 63, pass_to_hz=3.0, stop_from_hz=9.0)).figures
    assert figures.pass_min_db > (-3.1 if method == "rectangular" else -1.5)
    assert figures.stop_max_db < -18


def test_a_design_of_the_firmware_is_shown_at_the_rate_at_hand():
    figures = lowpass.design(Wish("lowpass32", RATE_HZ)).figures
    assert figures.settling_s == pytest.approx(32 / RATE_HZ)
    assert figures.stop_max_db <= -60  # its band moves with the rate: 8.6 Hz


@pytest.mark.parametrize(
    ("wish", "complaint"),
    [
        (Wish("boxcar", 80.0), "no method 'boxcar'; there are frequency-sampling"),
        (Wish("hamming", 0.0), "a rate of 0"),
        (Wish("hamming", float("nan")), "a rate of nan"),
        (Wish("hamming", 80.0, 65), "2 to 64 taps"),
        (Wish("hamming", 80.0, 1), "2 to 64 taps"),
        (Wish("hamming", 80.0, 32, pass_to_hz=40.0), "pass band"),
        (Wish("hamming", 80.0, 32, pass_to_hz=9.0, stop_from_hz=8.0), "above the pass band"),
        (Wish("hamming", 80.0, 32, stop_from_hz=41.0), "below 40 Hz"),
        (Wish("hamming", 80.0, 32, notches_hz=(-1.0,)), "above 0 Hz"),
        (Wish("hamming", 50.0, 32, notches_hz=(50.0,)), "where the weight itself is"),
        (Wish("hamming", 80.0, 4, notches_hz=(12.0, 20.0, 30.0)), "too many"),
    ],
)
def test_a_wish_that_makes_no_sense_is_refused(wish, complaint):
    with pytest.raises(ValueError, match=complaint):
        lowpass.design(wish)


def test_equiripple_refuses_bands_that_are_none():
    with pytest.raises(ValueError, match="stop band must begin"):
        equiripple.lowpass(32, 9.0, 8.0, 80.0)
    with pytest.raises(ValueError, match="2 taps"):
        equiripple.lowpass(1, 0.0, 8.0, 80.0)
    with pytest.raises(ValueError, match="no window"):
        windows.window("kaiser", 8)
    with pytest.raises(ValueError, match="below half"):
        windows.lowpass("hann", 8, 50.0, 80.0)


def test_only_equiripple_needs_scipy(monkeypatch):
    for name in [each for each in sys.modules if each.split(".")[0] == "scipy"]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, "scipy", None)
    for method in METHODS:
        if method == "equiripple":
            with pytest.raises(ModuleNotFoundError):
                lowpass.design(Wish(method, 80.0))
        else:
            lowpass.design(Wish(method, 80.0))
