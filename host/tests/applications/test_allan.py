# SPDX-License-Identifier: MIT
"""Figures read off the Allan deviation of noise whose coefficients are known, and refusals."""

import math
import sys

import numpy as np
import pytest

from terazi.applications.attitude.allan import FLAT, Record, allan, axis_of
from terazi.errors import CannotRead, UsageError

RATE_HZ = 100.0


def noise(seconds, *, white=0.0, flicker=0.0, walk=0.0, seed=1, rate_hz=RATE_HZ):
    """Noise of the two-sided density N^2 + B^2 / (2 pi f) + (K / 2 pi f)^2, IEEE Std 952."""
    count = round(seconds * rate_hz)
    rng = np.random.default_rng(seed)
    f = np.fft.rfftfreq(2 * count, 1 / rate_hz)  # twice as long: a period is no part of it
    f[0] = f[1]
    density = white**2 + flicker**2 / (2 * np.pi * f) + (walk / (2 * np.pi * f)) ** 2
    phases = rng.normal(size=len(f)) + 1j * rng.normal(size=len(f))
    return np.fft.irfft(phases * np.sqrt(density * rate_hz * count))[:count]


def by_definition(values, clusters, rate_hz):
    """Overlapping Allan deviation, straight from its definition: differences of means."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    means = (total[clusters:] - total[:-clusters]) / clusters
    apart = means[clusters:] - means[:-clusters]
    return math.sqrt(np.mean(apart**2) / 2)


def test_the_curve_is_the_overlapping_allan_deviation():
    values = noise(200, white=0.01, flicker=0.003)
    axis = axis_of(values, RATE_HZ)
    for at in (0, 7, len(axis.tau_s) - 1):
        clusters = round(axis.tau_s[at] * RATE_HZ)
        assert axis.deviation[at] == pytest.approx(by_definition(values, clusters, RATE_HZ))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_white_noise_is_read_off_and_has_no_instability_yet(seed):
    axis = axis_of(noise(900, white=0.0035, seed=seed), RATE_HZ)
    assert axis.white == pytest.approx(0.0035, rel=0.02)
    assert axis.density == pytest.approx(0.0035 * math.sqrt(2), rel=0.02)
    assert not axis.instability_is_seen
    assert axis.walk is None


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_flat_curve_is_the_instability(seed):
    axis = axis_of(noise(1800, flicker=0.002, seed=seed), RATE_HZ)
    assert axis.instability_is_seen
    assert axis.instability == pytest.approx(0.002, rel=0.15)
    assert axis.white is None


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_all_three_are_told_apart(seed):
    axis = axis_of(noise(7200, white=0.01, flicker=0.001, walk=0.0006, seed=seed), RATE_HZ)
    assert axis.white == pytest.approx(0.01, rel=0.03)
    assert axis.walk == pytest.approx(0.0006, rel=0.3)
    # Beside white noise and random walk the least lies higher than flicker alone would have it.
    tau = axis.instability_tau_s
    expected = math.sqrt(0.01**2 / tau + (0.001 * FLAT) ** 2 + 0.0006**2 * tau / 3) / FLAT
    assert axis.instability == pytest.approx(expected, rel=0.2)


def standstill(seconds=120, *, rate_hz=RATE_HZ, seed=5):
    """A record of white noise: 0.1 deg/s and 4 mg at 100 samples a second."""
    rng = np.random.default_rng(seed)
    count = round(seconds * rate_hz)
    gyro = rng.normal((8, -3, 5), 1.6, (count, 3))
    acc = rng.normal((10, -20, 2048), 8.0, (count, 3))
    rounded = (np.rint(each).astype(np.int16) for each in (gyro, acc))
    return Record("lies", rate_hz, np.arange(count), 1, *rounded)


def changed(record, **columns):
    import dataclasses

    return dataclasses.replace(record, **columns)


def test_a_records_figures_have_their_units():
    plain = allan(standstill()).plain()
    white_deg_s = math.sqrt((1.6**2 + 1 / 12) / RATE_HZ) / 16.384  # and of rounding
    white_g = math.sqrt((8**2 + 1 / 12) / RATE_HZ) / 2048
    for axis in plain["gyro"].values():
        assert axis["angle_random_walk_deg_rth"] == pytest.approx(60 * white_deg_s, rel=0.06)
        assert axis["density_deg_s_rthz"] == pytest.approx(white_deg_s * 2**0.5, rel=0.06)
    for axis in plain["acc"].values():
        walk = axis["velocity_random_walk_m_s_rth"]
        assert walk == pytest.approx(white_g * 9.80665 * 60, rel=0.06)
        assert axis["density_ug_rthz"] == pytest.approx(white_g * 1e6 * 2**0.5, rel=0.06)
    assert plain["datasheet"]["angle_random_walk_deg_rth"] == pytest.approx(0.2121, abs=1e-4)


def test_a_short_record_is_refused():
    with pytest.raises(CannotRead, match=r"59\.0 s without a gap are too short") as caught:
        allan(standstill(59))
    assert "an hour" in caught.value.remedy


@pytest.mark.parametrize("what", ["turn", "tilt", "knock", "shake"])
def test_a_record_that_moves_is_refused_and_says_when(what):
    record = standstill()
    gyro, acc = record.gyro_b_counts.copy(), record.acc_b_counts.copy()
    hit = slice(7000, 7100)
    if what == "turn":
        gyro[hit, 2] += 20  # 1.2 deg/s
    if what == "tilt":
        acc[7000:, 0] += 60  # 29 mg, from then on
    if what == "knock":
        acc[7040:7043, 2] += 1500
    if what == "shake":
        gyro[hit, 0] += np.resize((50, -50), 100).astype(np.int16)
    with pytest.raises(CannotRead, match=r"moves: at (69|70) s") as caught:
        allan(changed(record, gyro_b_counts=gyro, acc_b_counts=acc))
    assert "--begin" in caught.value.remedy


def test_a_bias_that_warms_up_is_no_movement():
    record = standstill(600)
    warming = np.rint(40 * np.arange(len(record)) / len(record)).astype(np.int16)  # 2.4 deg/s
    gyro = record.gyro_b_counts + warming[:, None]
    axis = allan(changed(record, gyro_b_counts=gyro)).gyro["x"]
    assert axis.instability_is_seen


def test_an_axis_without_any_noise_is_refused():
    record = standstill()
    acc = record.acc_b_counts.copy()
    acc[:, 1] = 7
    with pytest.raises(CannotRead, match="accelerometer gives one and the same value on y"):
        allan(changed(record, acc_b_counts=acc))


def test_of_a_record_with_gaps_the_longest_stretch_is_read():
    record = standstill(200)
    number = record.number.copy()
    number[5000:] += 3
    found = allan(changed(record, number=number))
    assert found.duration_s == pytest.approx(150.0)
    assert "from 50.0 to 200.0 s" in found.notes[0]
    number[12000:] += 3
    number[16000:] += 3
    with pytest.raises(CannotRead, match="too short"):
        allan(changed(record, number=number, every=1).between(100, 170))


def test_without_allantools_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "allantools", None)
    with pytest.raises(UsageError, match="needs allantools") as caught:
        allan(standstill())
    assert caught.value.remedy == "Install it: pip install 'terazi[allan]'"
