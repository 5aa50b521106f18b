# SPDX-License-Identifier: MIT
"""Drift elimination: it straightens a building's walk, and leaves every other path alone."""

from dataclasses import replace

import numpy as np
import pytest

from terazi.applications.walks import Options, estimate, path_errors, simulator
from terazi.applications.walks.complementary import ComplementarySettings
from terazi.applications.walks.elimination import eliminate

RAW = Options(
    navigator="complementary",
    roll_share=0.0,
    complementary=ComplementarySettings(bias="none"),
)
BENDING = np.radians(0.5)  # rad/s about the vertical


def biased(pieces, seed=1, yaw_rad_s=BENDING):
    """A walk whose gyroscope turns steadily about the vertical, and has no other error."""
    walk = simulator.simulate(pieces, seed=seed, mems=simulator.PERFECT, mount_wb=(1, 0, 0, 0))
    # In body axes: the vertical as each attitude sees it.
    return replace(walk, gyro_b_rad_s=np.add(walk.gyro_b_rad_s, [0, 0, yaw_rad_s]))


def both(walk):
    raw = estimate(walk, RAW)
    done = eliminate(raw.path, raw.strides, walk.t_s)
    errors = [path_errors(walk, pos).rmse_2d_m for pos in (raw.path.pos_w_m, done.path.pos_w_m)]
    return done, errors


@pytest.mark.parametrize("route", ["corridor", "round"])
def test_elimination_takes_a_steady_drift_out_of_a_building_s_walk(route):
    pieces = simulator.corridor() if route == "corridor" else simulator.square(14.0)
    done, (before_m, after_m) = both(biased(pieces))
    assert done.applied, done.words
    assert after_m < 0.5 * before_m


def test_elimination_keeps_heights_lengths_and_stances():
    raw = estimate(biased(simulator.corridor()), RAW)
    done = eliminate(raw.path, raw.strides, raw.walk.t_s)
    assert done.applied
    assert np.array_equal(done.path.pos_w_m[:, 2], raw.path.pos_w_m[:, 2])
    lengths = [np.linalg.norm(np.diff(path.pos_w_m, axis=0), axis=1)
               for path in (raw.path, done.path)]  # fmt: skip
    assert np.allclose(*lengths)
    assert np.allclose(np.linalg.norm(done.path.quat_wb, axis=1), 1)


FREE = {
    "circle": simulator.circle(5.0, rounds=2),
    "wide circle": simulator.circle(20.0),
    "zigzag": [
        *simulator.stand(3),
        *simulator.strides(6),
        *(each for turn in (0.6, -0.6) * 3
          for each in [*simulator.turning(turn), *simulator.strides(4)]),
    ],
    "oblique": [
        *simulator.stand(3),
        *simulator.strides(10),
        *simulator.turning(np.radians(25)),
        *simulator.strides(12),
        *simulator.turning(np.radians(110)),
        *simulator.strides(12),
    ],
    "bends at once": [*simulator.stand(3), *simulator.strides(20, turn_rad=0.35)],
    "few": [*simulator.stand(3), *simulator.strides(5)],
}  # fmt: skip


@pytest.mark.parametrize("name", FREE)
@pytest.mark.parametrize("seed", range(3))
def test_elimination_leaves_a_free_path_untouched(name, seed):
    walk = simulator.simulate(FREE[name], seed=seed)
    raw = estimate(walk)
    done = eliminate(raw.path, raw.strides, walk.t_s)
    assert not done.applied, done.words
    assert done.path is raw.path


def test_elimination_is_off_unless_asked_for_and_says_what_it_did():
    walk = biased(simulator.corridor())
    assert not any("elimination" in note for note in estimate(walk, RAW).walk.notes)
    asked = estimate(walk, replace(RAW, eliminate_drift=True))
    assert any("drift elimination applied" in note for note in asked.walk.notes)
