# SPDX-License-Identifier: MIT
"""The simulated checkweigher's belt: what it promises of itself."""

from dataclasses import replace

import numpy as np
import pytest

from terazi.applications.weighing.belt import Belt, simulate

QUIET = Belt(products=40, vibrations_hz_g=(), hum_g=0.0)


@pytest.fixture(scope="module")
def record():
    return simulate(QUIET)


def test_belt_of_one_seed_is_one_record_and_of_another_is_not():
    belt = Belt(products=4)
    assert np.array_equal(simulate(belt).load_g, simulate(belt).load_g)
    other = simulate(replace(belt, seed=belt.seed + 1))
    assert not np.allclose(other.load_g, simulate(belt).load_g)


def test_belt_carries_120_products_a_minute_each_300_ms_wholly_on_the_platform(record):
    enters = np.array([passage.enters_s for passage in record.passages])
    assert np.diff(enters).mean() == pytest.approx(0.5, abs=0.002)
    for before, after in zip(record.passages, record.passages[1:], strict=False):
        assert before.leaves_s < after.enters_s
    for passage in record.passages:
        assert passage.off_s - passage.on_s == pytest.approx(0.3)
        assert record.belt.ramp_s[0] <= passage.on_s - passage.enters_s <= record.belt.ramp_s[1]
        assert 200.0 <= passage.weight_g <= 1000.0


def test_belt_rings_as_a_damped_tone_of_the_loaded_platform(record):
    """y[n] + a y[n-1] + b y[n-2] = 0 of what is left without the weight, by the tone's own a, b."""
    rate_hz = record.belt.rate_hz
    for passage in record.passages:
        first = round((passage.on_s + record.belt.bump_s) * rate_hz) + 2
        ringing = record.load_g[first : round(passage.off_s * rate_hz) - 2] - passage.weight_g
        omega = 2 * np.pi * passage.tone_hz / rate_hz
        fade = np.exp(-passage.damping * omega)
        a = -2 * fade * np.cos(omega * np.sqrt(1 - passage.damping**2))
        left = ringing[2:] + a * ringing[1:-1] + fade**2 * ringing[:-2]
        assert np.abs(left).max() < 1e-9 * max(1.0, np.abs(ringing).max())
        assert np.abs(ringing).max() > 0.5


def test_belt_has_tones_over_its_whole_range():
    tones = [passage.tone_hz for passage in simulate(replace(QUIET, products=200)).passages]
    parts, _ = np.histogram(tones, 5.0 * 2 ** np.linspace(0, 2, 5))
    assert parts.min() > 30
    assert parts.sum() == 200
    assert min(tones) >= 5.0
    assert max(tones) <= 20.0


def test_belt_adds_vibration_and_hum_of_the_stated_size(record):
    belt = Belt(products=40)
    added = simulate(belt).load_g - record.load_g
    spectrum = np.abs(np.fft.rfft(added)) * 2 / len(added)
    at_hz = np.fft.rfftfreq(len(added), 1 / belt.rate_hz)
    for frequency_hz, amplitude_g in (*belt.vibrations_hz_g, (50.0, belt.hum_g)):
        near = np.abs(at_hz - frequency_hz) < 0.5
        assert spectrum[near].max() == pytest.approx(amplitude_g, rel=0.4)
    assert added.std() == pytest.approx(np.sqrt((0.03**2 + 0.05**2 + 0.1**2) / 2), rel=0.01)
