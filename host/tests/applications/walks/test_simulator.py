# SPDX-License-Identifier: MIT
"""The simulated foot: its truth and its sensor say the same."""

import numpy as np
import pytest

from terazi.applications.walks import simulator
from terazi.applications.walks.complementary import rotated
from terazi.cshared import Ins

ROUTES = {
    "square": simulator.square(6.0),
    "circle": simulator.circle(4.0),
    "run": [*simulator.stand(2), *simulator.strides(8, simulator.RUNNING), *simulator.stand(2)],
    "stairs": [*simulator.stand(2), *simulator.staircase(10), *simulator.stand(2)],
}


def perfect(name, rate_hz=200.0, seed=4):
    """A walk whose sensor is exact and sits level."""
    return simulator.simulate(
        ROUTES[name], seed=seed, rate_hz=rate_hz, mems=simulator.PERFECT, mount_wb=(1, 0, 0, 0)
    )


@pytest.mark.parametrize("name", ROUTES)
def test_simulator_integrated_without_any_update_gives_its_truth(name):
    """Strapdown alone: what remains is the integration's own error, of second order."""
    errors_m = []
    for rate_hz in (400.0, 800.0):
        walk = perfect(name, rate_hz)
        ins = Ins((1, 0, 0, 0), sigmas={}, noises={}, gravity_m_s2=9.81)
        none = np.zeros(len(walk))
        path, _ = ins.run(walk.dt_s, walk.acc_b_m_s2, walk.gyro_b_rad_s, none, none, none)
        errors_m.append(np.abs(path[:, :3] - walk.truth.pos_t_m).max())
    assert errors_m[1] < 0.05
    assert errors_m[1] < 0.3 * errors_m[0]


@pytest.mark.parametrize("name", ROUTES)
def test_simulator_measures_nothing_but_gravity_where_it_says_still(name):
    walk = perfect(name)
    rocking = simulator.WALKING.rock_rad * 9.81 + 1.0
    away = np.linalg.norm(walk.acc_b_m_s2[walk.zero_velocity] - [0, 0, 9.81], axis=1)
    assert away.max() < rocking
    begins = walk.t_s < 1.5
    assert np.allclose(walk.acc_b_m_s2[begins], [0, 0, 9.81])
    assert np.allclose(walk.gyro_b_rad_s[begins], 0)


def test_simulator_repeats_with_its_seed_and_differs_with_another():
    first, again, other = (
        simulator.simulate(ROUTES["square"], seed=seed).acc_b_m_s2 for seed in (7, 7, 8)
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_simulator_loops_close_and_stairs_climb():
    square = perfect("square").truth.pos_t_m
    assert np.linalg.norm(square[-1, :2] - square[0, :2]) < 2.5  # corners take a little way
    assert abs(perfect("circle").truth.pos_t_m[-1]).max() < 1e-9
    assert perfect("stairs").truth.pos_t_m[-1, 2] == pytest.approx(10 * 0.17)


def test_simulator_s_mount_turns_what_is_measured_and_nothing_else():
    quat = np.array([0.8, 0.36, -0.48, 0.0])
    level, tilted = (
        simulator.simulate(ROUTES["stairs"], seed=1, mems=simulator.PERFECT, mount_wb=mount)
        for mount in ((1, 0, 0, 0), quat)
    )
    turned = rotated(np.tile(quat, (len(level), 1)), tilted.acc_b_m_s2)
    assert np.allclose(turned, level.acc_b_m_s2)
    assert np.array_equal(level.truth.pos_t_m, tilted.truth.pos_t_m)
