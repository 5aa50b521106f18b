# SPDX-License-Identifier: MIT
"""A wrong rate, range or axis shows in the swings, which then do not end at rest."""

from dataclasses import replace

import numpy as np
import pytest

from terazi.applications.walks import estimate, simulator
from terazi.applications.walks.swings import LEAK_MOST, gravity_leak

PIECES = [*simulator.stand(2), *simulator.strides(8), *simulator.stand(1)]
WALK = simulator.simulate(PIECES, seed=6)
TURNED = np.array([0.5, 0.5, -0.5, 0.5])  # axes of the sensor, any


def doubts(walk):
    return [note for note in estimate(walk).walk.notes if "do not tell of one motion" in note]


@pytest.mark.parametrize("rate_hz", [100.0, 200.0, 1000.0])
@pytest.mark.parametrize("route", ["stairs", "run"])
def test_a_good_record_raises_no_doubt_at_any_rate(route, rate_hz):
    walk = simulator.simulate(simulator.ROUTES[route](), seed=2, rate_hz=rate_hz)
    assert not doubts(walk)


def test_without_errors_nothing_of_gravity_is_left_however_the_sensor_sits():
    walk = simulator.simulate(PIECES, seed=6, rate_hz=500, mems=simulator.PERFECT, mount_wb=TURNED)
    assert gravity_leak(walk, walk.zero_velocity) < 0.01


@pytest.mark.parametrize(
    "wrong",
    [
        {"t_s": WALK.t_s / 2},
        {"t_s": WALK.t_s * 2},
        {"gyro_b_rad_s": WALK.gyro_b_rad_s / 2},
        {"gyro_b_rad_s": WALK.gyro_b_rad_s * 2},
        {"gyro_b_rad_s": WALK.gyro_b_rad_s * [1, -1, 1]},
        {"gyro_b_rad_s": WALK.gyro_b_rad_s[:, [1, 0, 2]]},
        {"acc_b_m_s2": WALK.acc_b_m_s2 * [-1, 1, 1]},
    ],
    ids=["rate doubled", "rate halved", "range halved", "range doubled", "sign", "order", "force"],
)
def test_a_wrong_rate_range_or_axis_is_told(wrong):
    (note,) = doubts(replace(WALK, **wrong))
    share = float(note.split("swing ")[1].split(" %")[0]) / 100
    assert share > LEAK_MOST


def test_of_too_few_swings_nothing_is_said():
    one = simulator.simulate([*simulator.stand(2), *simulator.strides(1)], seed=6)
    assert gravity_leak(one, one.zero_velocity) is None
    assert gravity_leak(one, np.ones(len(one), bool)) is None
