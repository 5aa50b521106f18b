# SPDX-License-Identifier: MIT
"""FIR designs: what the quantised coefficients do, held to the limits of fir.toml."""

import numpy as np
import pytest

from terazi.design import fir, specs

DESIGNS = [design["name"] for design in specs.fir_designs()]


@pytest.mark.parametrize("name", DESIGNS)
def test_fir_design_keeps_the_limits_of_its_specification(name):
    design, taps = specs.fir_design(name), specs.fir_taps_q15(name)
    rate_hz = design["nominal_rate_hz"]
    stop_hz = np.linspace(design["stopband_from_hz"], rate_hz / 2, 4000)
    assert fir.magnitude_db(taps, stop_hz, rate_hz).max() <= design["stopband_max_db"]
    assert fir.noise_gain(taps) <= design["noise_gain_max"]
    assert fir.settling_samples(taps, within=1e-4) <= design["settling_samples_max"]
    overshoot = np.cumsum(taps).max() / 32768 - 1
    assert overshoot <= design["overshoot_max"]


@pytest.mark.parametrize("name", DESIGNS)
def test_fir_design_keeps_the_contract_of_the_c(name):
    taps = specs.fir_taps_q15(name)
    assert taps.sum() == 32768
    assert np.abs(taps).sum() < 65536
    assert np.array_equal(taps, taps[::-1])


@pytest.mark.parametrize("rate_hz", [78.0, 80.0, 92.0])
def test_lowpass32_stops_belt_vibration_and_folded_mains_hum_at_any_true_rate(rate_hz):
    """A filter's corner moves with the converter's clock, and so does where 50 and 60 Hz fold."""
    taps = specs.fir_taps_q15("lowpass32")
    folded_hz = [abs(mains - round(mains / rate_hz) * rate_hz) for mains in (50.0, 60.0)]
    disturbed_hz = [*np.linspace(10, 18, 200), *folded_hz]
    assert fir.magnitude_db(taps, disturbed_hz, rate_hz).max() <= -60


def test_frequency_sampling_goes_through_its_samples():
    wanted = [1.0, 0.57, 0.08]
    taps = fir.frequency_sampling(32, wanted)
    spectrum = np.abs(np.fft.fft(taps))
    assert np.allclose(spectrum[:16], wanted + [0.0] * 13, atol=1e-12)


def test_noise_gain_of_the_thesis_design_is_the_known_one_and_no_boxcar_is_beaten():
    """0.408 for 32 taps by frequency sampling; a boxcar of N has 1/sqrt(N), the least there is."""
    assert fir.noise_gain(specs.fir_taps_q15("passband32")) == pytest.approx(0.408, abs=0.001)
    for name in DESIGNS:
        taps = specs.fir_taps_q15(name)
        assert fir.noise_gain(taps) > 1 / np.sqrt(len(taps))
    assert fir.noise_gain(np.ones(16)) == pytest.approx(0.25)


def test_quantising_moves_no_coefficient_by_more_than_one_step():
    for name in DESIGNS:
        error = specs.fir_taps_q15(name) - specs.fir_taps(name) * 32768
        assert np.abs(error).max() <= 1.0


@pytest.mark.parametrize("taps", [2, 3, 8, 15, 16, 30, 51, 63, 64])
def test_quantised_coefficients_sum_to_one_for_any_length(taps):
    quantised = fir.quantise_q15(fir.frequency_sampling(taps, [1.0, 0.5][: max(1, taps // 4)]))
    assert quantised.sum() == 32768


def test_design_refuses_what_cannot_be_built():
    with pytest.raises(ValueError, match="2 taps"):
        fir.frequency_sampling(1, [1.0])
    with pytest.raises(ValueError, match="half the rate"):
        fir.frequency_sampling(4, [1.0, 1.0, 1.0])
    with pytest.raises(ValueError, match="no bin"):
        fir.frequency_sampling(5, [1.0, 1.0, 1.0, 1.0])
    with pytest.raises(ValueError, match="not symmetric"):
        fir.quantise_q15([0.9, 0.1])
    with pytest.raises(ValueError, match="finite"):
        fir.quantise_q15([np.nan, 1.0, np.nan])
    with pytest.raises(ValueError, match=r"break fir\.h"):
        fir.quantise_q15(np.array([-0.8, 1.3, 1.3, -0.8]))
    with pytest.raises(ValueError, match="no FIR design"):
        specs.fir_design("lowpass33")


def test_settling_counts_samples_until_a_step_stays():
    assert fir.settling_samples(np.ones(4), within=0.3) == 3
    assert fir.settling_samples(np.ones(4), within=1e-9) == 4
    assert fir.settling_samples([1.0], within=0.1) == 1
