# SPDX-License-Identifier: MIT
"""Peaks that the gyroscope's range cuts off are put back, and nothing else is touched."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.applications.walks import Options, clipping, estimate, path_errors, simulator
from terazi.applications.walks.clipping import AHEAD_S, clipping_note, unclipped

RANGE_RAD_S = 8.0  # of peaks of 10 rad/s


def runner(rate_hz=200.0, range_rad_s=np.inf):
    rng = np.random.default_rng(3)
    route = [*simulator.stand(2), *simulator.strides(12, simulator.RUNNING, rng=rng)]
    route += [*simulator.turning(2.0), *simulator.strides(12, simulator.RUNNING, rng=rng)]
    route += simulator.stand(2)
    mems = replace(simulator.Mems(), gyro_range_rad_s=range_rad_s)
    return simulator.simulate(route, seed=2, rate_hz=rate_hz, mems=mems, name="runner")


CLIPPED = runner(range_rad_s=RANGE_RAD_S)


def error_m(walk, **options):
    return path_errors(walk, estimate(walk, Options(**options)).path.pos_w_m).rmse_2d_m


@pytest.mark.parametrize("rate_hz", [100.0, 200.0, 1000.0])
def test_most_of_what_is_cut_off_comes_back_at_any_rate(rate_hz):
    true, clipped = runner(rate_hz), runner(rate_hz, RANGE_RAD_S)
    cut = np.abs(true.gyro_b_rad_s - clipped.gyro_b_rad_s).sum()
    left = np.abs(true.gyro_b_rad_s - clipped.rates.known_b_rad_s).sum()
    assert cut > 1.0 * rate_hz  # rad
    assert left < 0.12 * cut


@pytest.mark.parametrize("options", [{}, {"causal": True}, {"navigator": "complementary"}])
def test_a_path_is_about_as_good_as_with_a_wider_range(options, monkeypatch):
    restored_m, wide_m = error_m(CLIPPED, **options), error_m(runner(), **options)
    assert restored_m < 1.3 * wide_m
    monkeypatch.setattr(clipping, "ABOVE", np.inf)  # none is put back
    assert error_m(replace(CLIPPED), **options) > 2 * restored_m


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("axis", range(3))
def test_each_axis_is_restored_on_either_side(axis, side):
    column = int(np.argmax(np.ptp(CLIPPED.gyro_b_rad_s, axis=0)))
    turned = np.zeros_like(CLIPPED.gyro_b_rad_s)
    turned[:, axis] = side * CLIPPED.gyro_b_rad_s[:, column]
    found = unclipped(turned, 200.0)
    assert len(found.tops_rad_s) > 20
    assert found.tops_rad_s == pytest.approx(RANGE_RAD_S, rel=0.02)
    assert np.all(np.abs(found.known_b_rad_s) >= np.abs(turned))


@pytest.mark.parametrize("name", simulator.ROUTES)
def test_where_nothing_is_cut_off_nothing_is_changed(name):
    walk = simulator.simulate(simulator.ROUTES[name](), seed=1)
    assert np.array_equal(walk.rates.known_b_rad_s, walk.gyro_b_rad_s)
    assert np.array_equal(walk.rates.at_once_b_rad_s, walk.gyro_b_rad_s)
    assert not clipping_note(walk.rates)


@given(
    height=st.floats(4.5, 30.0),
    width_s=st.floats(0.03, 0.3),
    shape=st.sampled_from([np.cos, lambda x: np.exp(-(x**2)), lambda x: 1 - x**2 / 2]),
)
def test_a_round_peak_stays_as_it_is(height, width_s, shape):
    t_s = np.arange(-200, 200) / 200.0
    peak = np.maximum(height * shape(np.clip(t_s / width_s, -1.5, 1.5)), 0.0)
    rates = np.column_stack([peak, 0.1 * peak, np.zeros_like(peak)])
    assert np.array_equal(unclipped(rates, 200.0).known_b_rad_s, rates)


@given(count=st.integers(100, len(CLIPPED)))
def test_what_is_known_at_once_does_not_depend_on_what_comes(count):
    rate_hz = CLIPPED.rate_hz
    part, whole = unclipped(CLIPPED.gyro_b_rad_s[:count], rate_hz), CLIPPED.rates
    assert np.array_equal(part.at_once_b_rad_s, whole.at_once_b_rad_s[:count])
    final = max(0, count - round(AHEAD_S * rate_hz) - 2)
    assert np.array_equal(part.known_b_rad_s[:final], whole.known_b_rad_s[:final])


def test_at_once_the_turning_adds_up_to_what_is_known_in_the_end():
    whole = CLIPPED.rates
    np.testing.assert_allclose(
        whole.at_once_b_rad_s.sum(axis=0), whole.known_b_rad_s.sum(axis=0), rtol=1e-9, atol=1e-9
    )


def test_it_is_told_with_the_range():
    (note,) = (each for each in estimate(CLIPPED).walk.notes if "cut off" in each)
    assert f"{len(CLIPPED.rates.tops_rad_s)} peaks" in note
    assert "8 rad/s (458 deg/s)" in note
