# SPDX-License-Identifier: MIT
"""The report's figures, each against a signal whose answer is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.tests.captures import CaptureMaker
from host.tests.fake_chain import RATE_HZ
from terazi.recorder import load_recording
from terazi.report import Truth, analyse
from terazi.report.analysis import (
    found_steps_s,
    intervals_ms,
    noise_p2p,
    noise_rms,
    rate_of,
    rate_over_time,
    settling_time,
    spectra,
    time_s,
)
from terazi.report.truth import align

SEED = 20260101


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """16 s: 500 g are put on at 2 s and 10 s, taken off at 6 s and 14 s."""
    path = tmp_path_factory.mktemp("report") / "steps.terazi"
    return load_recording(CaptureMaker(path).hello().samples(round(16 * RATE_HZ)).end())


def exponential(seconds, tau_s):
    since_s = np.arange(0, seconds, 1 / RATE_HZ)
    return since_s, np.exp(-since_s / tau_s)


def test_settling_of_an_exponential_is_what_the_logarithm_says():
    since_s, error = exponential(4.0, tau_s=0.3)
    assert settling_time(since_s, error, 0.01) == pytest.approx(0.3 * np.log(100), abs=1 / RATE_HZ)


def test_settling_never_happens_under_noise_wider_than_the_band():
    since_s, error = exponential(4.0, tau_s=0.3)
    assert settling_time(since_s, error + 0.1 * np.sin(50 * since_s), 0.01) is None


def test_settling_is_at_once_where_the_band_is_never_left():
    since_s, error = exponential(4.0, tau_s=0.3)
    assert settling_time(since_s + 0.004, error, 1.5) == pytest.approx(0.004)


@given(band=st.floats(0.002, 0.5))
def test_settling_takes_longer_the_narrower_the_band(band):
    since_s, error = exponential(8.0, tau_s=0.3)
    assert settling_time(since_s, error, band) >= settling_time(since_s, error, 2 * band)


def test_steps_are_found_within_a_sample_of_where_they_are(recording):
    result = analyse(recording)
    assert [step.t_s for step in result.steps] == pytest.approx(
        [2.0, 6.0, 10.0, 14.0], abs=2 / RATE_HZ
    )
    assert [step.size_g for step in result.steps] == pytest.approx([500, -500, 500, -500], abs=0.5)


def test_steps_are_not_found_in_noise_alone():
    noise = np.random.default_rng(SEED).normal(0, 40, 4000)
    samples = {"raw_counts": noise, "flags": np.zeros(4000, np.uint8)}
    assert len(found_steps_s(np.arange(4000) / RATE_HZ, samples, RATE_HZ)) == 0


def test_swinging_pan_is_no_second_step():
    t_s = np.arange(0, 20, 1 / RATE_HZ)
    since_s = np.maximum(t_s - 10.0, 0.0)
    swing = 0.3 * np.exp(-since_s / 0.06) * np.cos(2 * np.pi * 23 * since_s)
    load = np.where(t_s >= 10.0, 600_000 * (1 - swing), 0.0)
    noise = np.random.default_rng(SEED).normal(0, 40, len(t_s))
    samples = {"raw_counts": load + noise, "flags": np.zeros(len(t_s), np.uint8)}
    assert found_steps_s(t_s, samples, RATE_HZ) == pytest.approx([10.0], abs=2 / RATE_HZ)


def test_two_steps_in_one_second_are_two():
    t_s = np.arange(0, 20, 1 / RATE_HZ)
    load = np.select([t_s < 10.0, t_s < 10.8], [0, 100_000], 250_000)
    samples = {"raw_counts": load, "flags": np.zeros(len(t_s), np.uint8)}
    assert found_steps_s(t_s, samples, RATE_HZ) == pytest.approx([10.0, 10.8], abs=2 / RATE_HZ)


def test_restart_of_the_filters_is_no_change_of_load(tmp_path):
    def load(t_s):
        return 84_000 if t_s < 4.0 else 500_000

    maker = CaptureMaker(tmp_path / "one.terazi", load).hello().samples(round(4 * RATE_HZ) - 1)
    recording = load_recording(maker.samples(round(4 * RATE_HZ), restart=True).end())
    assert analyse(recording).steps == []


def test_stages_settle_in_the_order_of_the_chain(recording):
    for step in analyse(recording).steps:
        settling = step.settling_s
        assert settling["raw"] < settling["fir"] < settling["kalman"] < 1.2
        assert settling["fir"] == pytest.approx(31 / RATE_HZ, abs=0.1)  # its window is full


def test_noise_is_that_of_the_generator_without_creep():
    rng = np.random.default_rng(SEED)
    creep = np.linspace(0, 50, 8000)
    values = creep + rng.normal(0, 2.5, 8000)
    plateaus = [(0, 4000), (5000, 8000)]
    assert noise_rms(values, plateaus) == pytest.approx(2.5, rel=0.03)
    assert 14 < noise_p2p(values, plateaus) < 25


def test_noise_falls_from_stage_to_stage(recording):
    noise = analyse(recording).noise_rms_g
    assert noise["raw"] == pytest.approx(40 * 2.328e-3, rel=0.1)
    assert noise["raw"] > 2 * noise["fir"]
    assert noise["fir"] > 1.2 * noise["kalman"] > 0


def test_spectrum_of_white_noise_is_flat_at_its_level():
    values = {"raw": np.random.default_rng(SEED).normal(0, 3.0, 60_000)}
    frequency_hz, density = spectra(values, [(0, 60_000)], RATE_HZ)
    assert frequency_hz[-1] == pytest.approx(RATE_HZ / 2)
    level = 3.0 / np.sqrt(RATE_HZ / 2)
    assert density["raw"][2:-2] == pytest.approx(level, rel=0.25)
    power = np.sum(density["raw"] ** 2) * (frequency_hz[1] - frequency_hz[0])
    assert power == pytest.approx(9.0, rel=0.05)


def test_spectrum_shows_a_shaking_machine_where_it_shakes():
    t_s = np.arange(8192) / RATE_HZ
    values = {"raw": 2.0 * np.sin(2 * np.pi * 13.7 * t_s)}
    frequency_hz, density = spectra(values, [(0, 8192)], RATE_HZ)
    assert frequency_hz[np.argmax(density["raw"])] == pytest.approx(13.7, abs=0.2)
    power = np.sum(density["raw"] ** 2) * (frequency_hz[1] - frequency_hz[0])
    assert power == pytest.approx(2.0, rel=0.02)  # amplitude^2 / 2


def test_rate_is_found_from_stamps_and_not_assumed(recording):
    result = analyse(recording)
    assert result.rate_hz == pytest.approx(RATE_HZ, rel=1e-5)
    _middle_s, rate_hz = rate_over_time(result.t_s, result.interval_ms)
    assert rate_hz == pytest.approx(RATE_HZ, rel=1e-4)


def test_intervals_know_nothing_across_a_loss_or_a_new_run():
    samples = {
        "conversion": np.array([65534, 65535, 0, 3, 4, 5], np.uint16),
        "boot": np.array([0, 0, 0, 0, 0, 1]),
        "device_us": np.array([0, 12_000, 24_000, 60_000, 72_000, 500]),
    }
    interval_ms = intervals_ms(samples)
    assert interval_ms[[0, 1, 3]] == pytest.approx(12.0)
    assert np.isnan(interval_ms[[2, 4]]).all()
    assert rate_of(interval_ms) == pytest.approx(1000 / 12)


def test_time_goes_on_by_the_hosts_clock_when_the_device_starts_anew():
    samples = {
        "device_us": np.array([5_000_000, 5_012_000, 100, 12_100]),
        "host_s": np.array([1.0, 1.012, 3.5, 3.512]),
        "boot": np.array([0, 0, 1, 1]),
    }
    assert time_s(samples) == pytest.approx([0, 0.012, 2.5, 2.512])


@given(shift_s=st.floats(-20, 20))
def test_truths_clock_is_fitted_to_a_sample_wherever_its_zero_lies(shift_s):
    rng = np.random.default_rng(SEED)
    t_s = np.arange(0, 16, 1 / RATE_HZ)
    truth = Truth(
        np.array([0.0, 3.0, 7.0, 8.5, 16.0]), np.array([0.0, 500.0, 1500.0, 200.0, 200.0])
    )
    measured_g = truth.at(t_s) + rng.normal(0, 4, len(t_s))
    moved = truth.shifted(-shift_s)
    assert align(moved, t_s, measured_g, RATE_HZ) == pytest.approx(shift_s, abs=1 / RATE_HZ)


def test_truth_gives_steps_and_errors(recording):
    truth = Truth(np.array([10.0, 12, 16, 20, 24, 26]), np.array([0.0, 500, 0, 500, 0, 0]))
    result = analyse(recording, truth)
    assert result.truth_shift_s == pytest.approx(-10.0 - 1 / RATE_HZ, abs=1 / RATE_HZ)
    begun_s = np.array([2, 6, 10, 14]) - 1 / RATE_HZ  # the first sample is the axis's zero
    assert [step.t_s for step in result.steps] == pytest.approx(begun_s, abs=1 / RATE_HZ)
    errors_g, noise_g = result.truth_error_g, result.noise_rms_g["raw"]
    assert errors_g["kalman"] < 0.25, "zero was set, within R76's e/4 of where nothing lies"
    assert errors_g["raw"] == pytest.approx(np.hypot(errors_g["kalman"], noise_g), rel=0.05)


def test_short_recordings_have_fewer_figures_but_no_fault(tmp_path):
    for count in (1, 2, 3, 9, 40):
        maker = CaptureMaker(tmp_path / f"{count}.terazi").hello().samples(count)
        result = analyse(load_recording(maker.end()))
        assert result.steps == []
