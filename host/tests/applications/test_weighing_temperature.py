# SPDX-License-Identifier: MIT
"""The fit of a temperature run: what it finds, and what it refuses."""

import numpy as np
import pytest

from terazi.applications.weighing.temperature import TemperatureRunRefused, fit
from terazi.cshared import Temperature

ZERO, SPAN, LOAD, ORIGIN_20 = 107.0, 38.0, 859_100.0, 84_000.0  # a usual cell, 2 kg


def cell(warm_c, load_counts, *, seed, noise=5.0):
    """Counts of a cell that drifts, averaged to a few counts of noise."""
    above_k = warm_c - 20.0
    counts = ORIGIN_20 + ZERO * above_k + load_counts * (1 + SPAN * 1e-6 * above_k)
    return np.rint(counts + np.random.default_rng(seed).normal(0, noise, len(warm_c)))


def run(*, moved_k=12.0, n=600, seed=3):
    warm = 18.0 + moved_k * np.linspace(0, 1, n) ** 0.5
    return warm, cell(warm, 0.0, seed=seed), warm[::-1], cell(warm[::-1], LOAD, seed=seed + 1)


def test_temperature_fit_finds_the_drifts_of_zero_and_span():
    found = fit(*run())
    assert found.zero_counts_per_k == pytest.approx(ZERO, abs=0.2)
    assert found.span_ppm_per_k == pytest.approx(SPAN, abs=0.5)
    assert found.reference_c == pytest.approx(24.0)
    assert found.settings["origin_counts"] == pytest.approx(ORIGIN_20 + ZERO * 4, abs=3)
    assert found.moved_k == pytest.approx(12.0)
    assert found.helps


def test_temperature_fit_leaves_the_noise_of_the_run_and_no_drift():
    found = fit(*run())
    for series in (found.empty, found.loaded):
        assert series.before_rms > 200
        assert series.after_rms < 6.0  # the noise is 5
        assert series.after_span < series.before_span / 20


def test_temperature_fit_is_what_the_device_corrects_with():
    """Its settings in the device's C: empty and loaded stay put over 12 K, to within a 1/5 g."""
    empty_c, _, _, _ = run()
    found = fit(*run())
    for load in (0.0, LOAD, LOAD / 3):
        device = Temperature(**found.settings)
        raw = cell(empty_c, load, seed=9, noise=0.0).astype(int)
        corrected = []
        for warm, counts in zip(empty_c, raw, strict=True):
            device.update(round(100 * warm))
            for _ in range(60):  # the thermometer's smoothing has come to rest
                device.update(round(100 * warm))
            corrected.append(device.correct(int(counts)))
        assert np.ptp(corrected) < 86


def test_temperature_fit_of_the_zero_alone_leaves_the_span_as_it_is():
    empty_c, empty, _, _ = run()
    found = fit(empty_c, empty)
    assert found.zero_counts_per_k == pytest.approx(ZERO, abs=0.2)
    assert found.span_ppm_per_k == 0.0
    assert found.settings["span_ppm_per_k_q4"] == 0
    assert found.loaded is None
    assert found.helps


def test_temperature_fit_corrects_to_the_reference_that_is_asked_for():
    found = fit(*run(), reference_c=20.0)
    assert found.settings["reference_centi"] == 2000
    assert found.settings["origin_counts"] == pytest.approx(ORIGIN_20, abs=3)


def test_temperature_fit_refuses_a_run_that_hardly_moved():
    with pytest.raises(TemperatureRunRefused, match=r"nothing on: the temperature moved by 2\.9 K"):
        fit(*run(moved_k=2.9))
    empty_c, empty, loaded_c, loaded = run()
    still = slice(0, 10)
    with pytest.raises(TemperatureRunRefused, match="mass on: the temperature moved"):
        fit(empty_c, empty, loaded_c[still], loaded[still])
    assert fit(*run(moved_k=3.1)).moved_k == pytest.approx(3.1)


def test_temperature_fit_refuses_what_is_no_run():
    empty_c, empty, loaded_c, loaded = run()
    with pytest.raises(TemperatureRunRefused, match="7 samples"):
        fit(empty_c[::90], empty[::90])
    with pytest.raises(TemperatureRunRefused, match="hardly be told"):
        fit(empty_c, empty, loaded_c, cell(loaded_c, 20.0, seed=1))
    with pytest.raises(TemperatureRunRefused, match="span's drift"):
        fit(empty_c, empty, loaded_c, loaded * (1 + 300e-6 * (loaded_c - 20)))
    with pytest.raises(TemperatureRunRefused, match="zero's drift"):
        fit(empty_c, empty + 3000 * empty_c)
    with pytest.raises(ValueError, match="differ in length"):
        fit(empty_c, empty[1:])
    with pytest.raises(ValueError, match="not a number"):
        fit(empty_c, np.where(empty > empty[9], np.nan, empty))
