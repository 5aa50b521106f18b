# SPDX-License-Identifier: MIT
"""Gain schedules of the Kalman filter."""

import math

import pytest

from terazi.design import specs, weight_kf


def test_schedule_without_drift_is_the_running_mean():
    gains = weight_kf.gain_schedule(process_var=0, noise_var=1, initial_var=math.inf, length=5)
    assert gains == pytest.approx([1, 1 / 2, 1 / 3, 1 / 4, 1 / 5])


def test_schedule_ends_at_the_gain_of_the_riccati_equation():
    q, r = 12.0, 1500.0
    gains = weight_kf.gain_schedule(process_var=q, noise_var=r, initial_var=1e9, steady_within=1e-6)
    # Steady state: K = P / (P + R) with P = (1 - K) P + Q, hence K^2 R = (1 - K) Q.
    steady = gains[-1]
    assert steady**2 * r == pytest.approx((1 - steady) * q, rel=1e-5)
    assert gains == sorted(gains, reverse=True)


@pytest.mark.parametrize("name", [entry["name"] for entry in specs.weight_kf_schedules()])
def test_quantised_schedule_keeps_the_contract_of_the_c(name):
    gains = specs.weight_kf_gains_q15(name)
    assert 1 <= len(gains) <= 255
    assert all(1 <= gain <= 32768 for gain in gains)


def test_quantising_never_lets_the_filter_stand_still():
    assert weight_kf.quantise_q15([1e-9, 1.0]) == [1, 32768]


def test_schedule_refuses_what_it_cannot_do():
    common = {"process_var": 1e-9, "noise_var": 1.0, "initial_var": math.inf}
    with pytest.raises(ValueError, match="either"):
        weight_kf.gain_schedule(**common)
    with pytest.raises(ValueError, match="either"):
        weight_kf.gain_schedule(**common, steady_within=0.1, length=3)
    with pytest.raises(ValueError, match="more than 255"):
        weight_kf.gain_schedule(**common, steady_within=1e-3)
    with pytest.raises(ValueError, match="no gain schedule"):
        specs.weight_kf_schedule(7)
