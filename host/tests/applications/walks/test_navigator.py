# SPDX-License-Identifier: MIT
"""Both navigators on walks whose path is known exactly, and laws that hold for any walk."""

from dataclasses import replace

import numpy as np
import pytest

from terazi.applications.walks import ALL_DETECTORS, Options, estimate, path_errors, simulator
from terazi.applications.walks.navigator import KalmanSettings, stance_ages
from terazi.cshared import Ins

OF_SAMPLES = [name for name in ALL_DETECTORS if name != "device"]
SQUARE = simulator.simulate(simulator.square(10.0), seed=11, name="square")


def error_2d_m(walk, **options):
    result = estimate(walk, Options(**options))
    return path_errors(walk, result.path.pos_w_m).rmse_2d_m


@pytest.mark.parametrize(
    "route",
    [simulator.square(10.0), simulator.circle(5.0), simulator.corridor()],
    ids=["square", "circle", "corridor"],
)
def test_kalman_finds_a_perfect_sensor_s_path_within_millimetres(route):
    walk = simulator.simulate(route, seed=1, mems=simulator.PERFECT)
    assert error_2d_m(walk, roll_share=0.0) < 0.003


@pytest.mark.parametrize("seed", range(4))
def test_kalman_stays_within_one_percent_of_a_square_of_40_m(seed):
    walk = simulator.simulate(simulator.square(10.0), seed=seed)
    assert error_2d_m(walk) < 0.4
    assert error_2d_m(walk, causal=True) < 0.8


@pytest.mark.parametrize("detector", OF_SAMPLES)
def test_every_detector_brings_a_walker_home(detector):
    assert error_2d_m(SQUARE, detector=detector) < 1.0


def test_complementary_navigator_finds_the_path_too():
    assert error_2d_m(SQUARE, navigator="complementary") < 1.0


def test_kalman_without_zero_velocity_would_be_lost():
    """The claim that all of this rests on: the same integration, unaided."""
    ins = Ins((1, 0, 0, 0), sigmas={}, noises={}, gravity_m_s2=9.81)
    none = np.zeros(len(SQUARE))
    path, _ = ins.run(SQUARE.dt_s, SQUARE.acc_b_m_s2, SQUARE.gyro_b_rad_s, none, none, none)
    assert path_errors(SQUARE, path[:, :3]).rmse_2d_m > 20


def test_heading_at_the_start_is_free_and_the_mount_does_not_matter():
    mounts = [(1, 0, 0, 0), (0, 1, 0, 0), (0.5, 0.5, -0.5, 0.5)]
    errors = [
        error_2d_m(
            simulator.simulate(
                simulator.square(5.0), seed=3, mems=simulator.PERFECT, mount_wb=mount
            ),
            roll_share=0.0,
        )
        for mount in mounts
    ]
    assert max(errors) < 0.003


@pytest.mark.parametrize(("begin_s", "most_m"), [(0.3, 1.5), (0.0, 3.0)], ids=["stance", "swing"])
@pytest.mark.parametrize("seed", range(3))
def test_a_record_may_begin_without_a_standstill(seed, begin_s, most_m):
    """Of 0.3 s no bias is learnt; in a swing not even the tilt is known."""
    route = [*simulator.stand(begin_s), *simulator.square(10.0)[1:-1]]
    assert error_2d_m(simulator.simulate(route, seed=seed)) < most_m


def test_level_floors_hold_the_height_and_stairs_still_climb():
    flat = [*simulator.stand(3), *simulator.strides(30), *simulator.stand(2)]
    walk = simulator.simulate(flat, seed=8, mems=replace(simulator.Mems(), acc_scale=0.01))
    held = estimate(walk).path.pos_w_m[-1, 2]
    free = estimate(walk, Options(kalman=KalmanSettings(level_gate_m=0.0))).path.pos_w_m[-1, 2]
    assert abs(held) < 0.05
    assert abs(held) < 0.5 * abs(free)
    flight = [*simulator.stand(3), *simulator.staircase(12), *simulator.stand(2)]
    climbed = estimate(simulator.simulate(flight, seed=8)).path.pos_w_m[-1, 2]
    assert climbed == pytest.approx(12 * 0.17, abs=0.1)


def test_level_floors_leave_a_ramp_of_eight_percent_alone():
    up_m = 0.08 * simulator.WALKING.length_m
    ramp = [*simulator.stand(3), *simulator.strides(12, up_m=up_m), *simulator.stand(2)]
    path = estimate(simulator.simulate(ramp, seed=9)).path
    assert path.pos_w_m[-1, 2] == pytest.approx(12 * up_m, rel=0.1)


def test_states_of_scale_and_gravity_are_an_option_that_works():
    settings = KalmanSettings(
        gyro_scale_sigma=0.003, acc_scale_sigma=0.003, gravity_sigma_m_s2=0.02
    )
    options = Options(kalman=settings)
    result = estimate(SQUARE, options)
    assert path_errors(SQUARE, result.path.pos_w_m).rmse_2d_m < 0.4


def test_progress_is_told_and_ends_at_one():
    told = []
    estimate(SQUARE, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0
    assert len(told) > 5


def test_stance_ages_count_from_one_in_each_stance():
    still = np.array([1, 1, 0, 0, 1, 1, 1, 0, 1], bool)
    assert stance_ages(still).tolist() == [1, 2, 0, 0, 1, 2, 3, 0, 1]
