# SPDX-License-Identifier: MIT
"""mpu6050 and mpu6050_motion: samples at full rate, identity, self-test, loss and return."""

import os
import struct
from pathlib import Path

import numpy as np
import pytest

from terazi.applications.attitude.trials import find_trials, load_trial

ABSENT, RUNNING = 0, 2
SAMPLE = struct.Struct("<3hh3hI")  # mpu6050_sample_t; the chip pads nothing
KEPT = 16
RATES = {"mpu6050_motion_500hz": 500, "mpu6050_motion_1khz": 1000}


@pytest.fixture(params=RATES)
def motion(request, program):
    made = program("motion.c", ("mpu6050", "mpu6050_motion"), f"-DSETUP={request.param}")
    made.rate_hz = RATES[request.param]
    return made


@pytest.fixture
def running(motion):
    motion.board.imu.fit()
    motion.board.run_until(lambda: motion.number("state", 1) == RUNNING, 1.0)
    return motion


def overruns(motion):
    return motion.number("counters")


def losses(motion):
    return motion.number("counters", at=2)


def taken(motion):
    """The samples kept, oldest first."""
    count = motion.number("count", 4)
    raw = motion.board.peek(motion.board.symbol("samples"), KEPT * SAMPLE.size)
    kept = list(SAMPLE.iter_unpack(raw))
    return kept[count % KEPT :] + kept[: count % KEPT] if count >= KEPT else kept[:count]


def test_every_sample_arrives_once_and_in_order(running):
    rows = np.arange(6000).reshape(2000, 3)
    running.board.run(0.1)
    running.board.imu.play(rows % 8000, rows % 8000 + 8000, np.arange(2000))
    before = running.number("count", 4)
    seen = []
    while running.board.imu.played < 1990:
        running.board.run(8 / running.rate_hz)
        fresh = running.number("count", 4) - before
        before += fresh
        seen += taken(running)[-fresh:] if fresh else []
    numbers = [each[3] for each in seen if each[4] >= 8000]
    assert len(numbers) > 1900
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    for *_, number, gyro_x, _, gyro_z, _ in seen[-50:]:
        assert (gyro_x, gyro_z) == (3 * number + 8000, 3 * number + 8002)
    assert overruns(running) == losses(running) == 0
    assert running.number("recoveries") == 0


def test_samples_are_stamped_when_they_were_ready(running):
    running.board.run(0.5)
    stamps = np.array([each[-1] for each in taken(running)])
    assert np.abs(np.diff(stamps) - 1e6 / running.rate_hz).max() <= 10
    assert 0 <= running.board.seconds * 1e6 - stamps[-1] < 2.5e6 / running.rate_hz


def test_counts_are_those_of_the_ranges_chosen(running):
    running.board.imu.feel(
        acc_g=(0.5, -1.0, 15.0), gyro_deg_s=(100.0, -1900.0, 0.0), temperature_c=41.3
    )
    running.board.run(0.2)
    *acc, _, x, y, z, _ = taken(running)[-1]
    assert acc == [1024, -2048, 30720]
    assert (x, y, z) == (1640, -31160, 0)
    assert running.number("temperature_centi", signed=True) == pytest.approx(4130, abs=1)


@pytest.mark.parametrize("who", [0x68, 0x98, 0x72, 0x70])
def test_siblings_are_named_and_served(motion, who):
    motion.board.imu.fit(who_am_i=who)
    motion.board.run(0.2)
    assert motion.number("identity", 1) == who
    assert motion.number("state", 1) == RUNNING
    assert motion.number("count", 4) > 40


def test_a_reset_in_mid_flight_is_seen_within_20_ms_and_set_right(running):
    running.board.run(0.1)
    running.board.imu.power_cycle()
    reset_s = running.board.seconds
    # a part that sleeps tells of no data, so that nobody asks for any
    running.board.run_until(lambda: losses(running) == 1, 0.3, step_s=1e-4)
    assert running.board.seconds - reset_s <= 0.020
    running.board.run_until(lambda: running.number("state", 1) == RUNNING, 0.5)
    assert running.board.seconds - reset_s < 0.5
    count = running.number("count", 4)
    running.board.run(0.1)
    assert running.number("count", 4) - count == pytest.approx(running.rate_hz / 10, abs=2)


def test_unplugged_it_is_absent_and_back_within_half_a_second(running):
    running.board.run(0.1)
    running.board.imu.unplug()
    gone_s = running.board.seconds
    running.board.run_until(lambda: running.number("state", 1) == ABSENT, 0.3, step_s=1e-4)
    assert running.board.seconds - gone_s <= 0.020
    running.board.run(1.0)
    assert losses(running) == 1
    assert running.board.stats["twi_nacks"] <= 8  # four a second
    running.board.imu.plug()
    back_s = running.board.seconds
    count = running.number("count", 4)
    running.board.run_until(lambda: running.number("count", 4) > count, 1.0)
    assert running.board.seconds - back_s < 0.5


def test_a_stuck_bus_is_recovered_and_the_samples_go_on(running):
    running.board.run(0.1)
    running.board.bus.fault("sda_stuck", clocks=9)
    count, stuck_s = running.number("count", 4), running.board.seconds
    running.board.run_until(lambda: running.number("recoveries") == 1, 0.1, step_s=1e-4)
    assert running.board.seconds - stuck_s <= 0.020
    running.board.run(0.6)
    assert running.number("state", 1) == RUNNING
    assert running.number("count", 4) - count > 0.25 * running.rate_hz
    assert running.number("recoveries") == 1


def test_no_part_at_all_is_asked_four_times_a_second(motion):
    with motion.board.profile() as profile:
        motion.board.run(2.0)
    assert motion.number("state", 1) == ABSENT
    assert motion.number("identity", 1) == 0
    assert motion.board.stats["twi_starts"] == pytest.approx(8, abs=1)
    assert profile.cpu_load < 0.01


def promised(trim):
    """Self-test answers that the trim codes promise, in the order of a sample."""
    acc = [trim[n] >> 3 & 0x1C | trim[3] >> 4 - 2 * n & 3 for n in range(3)]
    gyro = [trim[n] & 0x1F for n in range(3)]
    acc = [4096 * 0.34 * (0.92 / 0.34) ** ((n - 1) / 30) if n else 0 for n in acc]
    gyro = [25 * 131 * 1.046 ** (n - 1) if n else 0 for n in gyro]
    return np.array([*acc, 0, gyro[0], -gyro[1], gyro[2]])


def judged(motion, trim, answer):
    motion.board.run(0.005)  # its memory is cleared first
    motion.board.poke(motion.board.symbol("trim"), bytes(trim))
    motion.board.poke(
        motion.board.symbol("answer"), struct.pack("<7h", *np.rint(answer).astype(int))
    )
    motion.board.poke(motion.board.symbol("judge"), b"\1")
    motion.board.run_until(lambda: motion.number("judge", 1) == 0, 0.1)
    return bool(motion.number("passes", 1))


@pytest.mark.parametrize("code", [1, 2, 16, 31])
def test_self_test_passes_within_14_percent_of_what_is_promised(motion, code):
    trim = [(code & 0x1C) << 3 | code] * 3 + [(code & 3) * 0x15]
    answer = promised(trim)
    for share in (1.0, 1.135, 0.865):
        assert judged(motion, trim, share * answer)
    for axis in (0, 1, 2, 4, 5, 6):
        for share in (1.145, 0.855, -1.0, 0.0):
            bad = answer.copy()
            bad[axis] *= share
            assert not judged(motion, trim, bad)


def test_self_test_of_a_part_that_was_never_trimmed_passes(motion):
    assert judged(motion, [0] * 4, np.zeros(7))


def test_self_test_of_the_simulated_part_passes(program):
    answers = []
    for setup in ("mpu6050_self_test_off", "mpu6050_self_test_on"):
        motion = program("motion.c", ("mpu6050", "mpu6050_motion"), f"-DSETUP={setup}")
        motion.board.imu.fit()
        motion.board.run(0.3)
        answers.append(np.array(taken(motion)[-1][:7]))
    trim = motion.board.imu.registers[0x0D:0x11]
    assert judged(motion, trim, answers[1] - answers[0])


def test_a_recording_played_into_the_part_reaches_the_program_sample_by_sample(program):
    folder = os.environ.get("TERAZI_DATA")
    if not folder:
        pytest.skip("TERAZI_DATA is unset: no recording of an IMU to play")
    trial = load_trial(find_trials(Path(folder) / "attitude" / "broad")[0])
    acc, gyro = (each[:1500] for each in (trial.acc_b_counts, trial.gyro_b_counts))
    motion = program("motion.c", ("mpu6050", "mpu6050_motion"), "-DSETUP=mpu6050_motion_500hz")
    motion.board.imu.fit()
    motion.board.run(0.2)
    motion.board.imu.play(acc, gyro, np.arange(len(acc)))
    before, seen = motion.number("count", 4), []
    while motion.board.imu.played < len(acc) - 1:
        motion.board.run(0.016)
        fresh = motion.number("count", 4) - before
        before += fresh
        seen += taken(motion)[-fresh:] if fresh else []
    rows = {each[3]: each for each in seen if 0 <= each[3] < len(acc)}
    numbers = sorted(rows)
    assert len(numbers) >= len(acc) - 16
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    wanted = np.hstack([acc, gyro])[numbers]
    got = np.array([[*rows[n][:3], *rows[n][4:7]] for n in numbers])
    assert np.array_equal(got, wanted)
