# SPDX-License-Identifier: MIT
"""The adaptive line enhancer, and the eggs that it is compared over."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.design import comparison
from terazi.models import lms

WINDOWS = comparison.WINDOWS


def test_a_line_is_learnt_and_taken_off_and_the_weight_stays():
    n = np.arange(3000)
    rhythm = 800 * np.sin(2 * np.pi * 5.0 / 80 * n)  # whole periods in the mean
    line, rest = lms.line_enhancer(429_550 + rhythm, step=0.02)
    late = slice(2500, None)
    assert np.abs(rest[late] - 429_550).max() < 8  # of 800
    assert np.abs(line[late] - rhythm[late]).max() < 8
    assert np.abs(rest[:20] - 429_550).max() > 400  # nothing known yet


def test_white_noise_is_not_predicted():
    noise = np.random.default_rng(5).normal(0, 39, 6000)
    line, rest = lms.line_enhancer(noise, step=0.005)
    assert line[3000:].std() < 0.45 * noise.std()
    assert rest[3000:].std() < 1.15 * noise.std()


@given(
    samples=st.lists(st.integers(-(2**23), 2**23 - 1), max_size=60),
    step=st.floats(0.001, 1.9),
    taps=st.integers(1, 8),
    delay=st.integers(1, 5),
)
def test_both_outputs_are_finite_and_add_up_to_the_samples(samples, step, taps, delay):
    line, rest = lms.line_enhancer(samples, taps=taps, delay_samples=delay, step=step)
    assert np.all(np.isfinite(line))
    assert np.allclose(line + rest, samples, rtol=1e-9, atol=1e-6)


@given(level=st.integers(-(2**23), 2**23 - 1), length=st.integers(1, 80))
def test_a_constant_passes_untouched(level, length):
    line, rest = lms.line_enhancer([level] * length)
    assert np.all(line == 0)
    assert np.all(rest == level)


def test_it_looks_back_only():
    rng = np.random.default_rng(9)
    samples = rng.normal(0, 1000, 300)
    changed = samples.copy()
    changed[200:] = 5e6
    ours, theirs = lms.line_enhancer(samples), lms.line_enhancer(changed)
    assert np.array_equal(ours.line_counts[:201], theirs.line_counts[:201])


def test_nan_is_skipped():
    samples = np.full(50, 100.0)
    samples[[0, 7, 8]] = np.nan
    assert np.all(lms.line_enhancer(samples).rest_counts == 100.0)
    assert lms.line_enhancer([np.nan] * 3).rest_counts.size == 0
    assert lms.line_enhancer([]).line_counts.size == 0


@pytest.mark.parametrize("wrong", [{"step": 0}, {"step": 2}, {"taps": 0}, {"delay_samples": 0}])
def test_what_does_not_converge_is_refused(wrong):
    with pytest.raises(ValueError, match=r"converge|at least 1"):
        lms.line_enhancer([1.0], **wrong)


def test_the_running_mean_is_the_mean_of_the_last_samples():
    samples = np.arange(10.0) ** 2
    mean = lms._running_mean(samples, 4)
    assert mean[6] == pytest.approx(samples[3:7].mean())
    assert mean[0] == 0


@pytest.fixture(scope="module")
def rows():
    """Relative error in percent by rhythm of the belt and filter."""
    return {
        hz: {
            row.filter: row.relative_error_pct
            for row in comparison.run(comparison.Experiment(belt_hz=hz))
        }
        for hz in comparison.BELTS_HZ
    }


def test_lms_pays_where_the_belt_is_as_slow_as_the_windows(rows):
    slow = rows[2.2]
    assert slow["lms, rectangular"] < 0.5 * min(slow[each] for each in WINDOWS)


def test_a_lines_rest_is_what_the_mean_lets_pass():
    n = np.arange(4000)
    mean_gain = abs(np.exp(-2j * np.pi * 4.3 / 80 * np.arange(32)).mean())
    rest = lms.line_enhancer(800 * np.sin(2 * np.pi * 4.3 / 80 * n), step=0.02).rest_counts
    assert np.abs(rest[3500:]).max() == pytest.approx(800 * mean_gain, rel=0.02)


def test_a_window_of_twice_the_length_does_as_well_as_lms(rows):
    for each in rows.values():
        assert each[comparison.LONG] < 1.3 * each["lms, rectangular"]


def test_lms_is_worth_nothing_where_a_window_stops_the_belt(rows):
    fast = rows[9.0]
    assert min(fast[each] for each in WINDOWS) < 0.03
    assert fast["lms, rectangular"] > 0.7 * fast["hann"]


def test_every_filter_is_better_than_none_and_the_experiment_repeats(rows):
    for each in rows.values():
        assert all(error < each["none"] for name, error in each.items() if name != "none")
    again = comparison.run(comparison.Experiment(belt_hz=2.2))
    assert {row.filter: row.relative_error_pct for row in again} == rows[2.2]
    other = comparison.run(comparison.Experiment(belt_hz=2.2, seed=1))
    assert other != again


def test_reads_are_taken_at_the_end_of_each_dwell():
    still = dataclasses.replace(comparison.Experiment(), belt_g=0.0, harmonic_g=0.0, noise_g=0.0)
    samples_g, true_g, reads = comparison.signal(still)
    assert samples_g[reads].tolist() == true_g.tolist()
    rows = {row.filter: row.relative_error_pct for row in comparison.run(still)}
    assert max(rows[each] for each in (*WINDOWS, comparison.LONG, "lowpass32", "none")) < 1e-6
