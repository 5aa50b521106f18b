# SPDX-License-Identifier: MIT
"""mpu6050_motion: samples at full rate, pacing, identity, modes, loss and return."""

import os
import struct
from pathlib import Path

import numpy as np
import pytest

from terazi.applications.attitude.trials import find_trials, load_trial

DRIVERS = ("mpu6050", "mpu6050_motion", "mpu6050_pace")
ABSENT, RUNNING = 0, 2
SAMPLE = struct.Struct("<3hh3hI")  # mpu6050_sample_t; the chip pads nothing
KEPT = 16
ISR_CYCLES_MAX, IRQ_OFF_CYCLES_MAX = 200, 40  # firmware/budget.toml
OFF, HZ_500, HZ_1000, SELF_TEST_OFF, SELF_TEST_ON, TRIM = range(6)
RATES = {HZ_500: 500, HZ_1000: 1000}


def in_mode(program, mode):
    return program("motion.c", DRIVERS, f"-DMODE={mode}")


@pytest.fixture(params=RATES, ids=lambda mode: f"{RATES[mode]}hz")
def motion(request, program):
    made = in_mode(program, request.param)
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
    count = motion.number("sample_count", 4)
    raw = motion.board.peek(motion.board.symbol("samples"), KEPT * SAMPLE.size)
    kept = list(SAMPLE.iter_unpack(raw))
    return kept[count % KEPT :] + kept[: count % KEPT] if count >= KEPT else kept[:count]


def test_every_sample_arrives_once_and_in_order(running):
    rows = np.arange(6000).reshape(2000, 3)
    running.board.run(0.1)
    running.board.imu.play(rows % 8000, rows % 8000 + 8000, np.arange(2000))
    before = running.number("sample_count", 4)
    seen = []
    while running.board.imu.played < 1990:
        running.board.run(8 / running.rate_hz)
        fresh = running.number("sample_count", 4) - before
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
    assert motion.number("sample_count", 4) > 40


def test_a_reset_in_mid_flight_is_seen_within_20_ms_and_set_right(running):
    running.board.run(0.1)
    running.board.imu.power_cycle()
    reset_s = running.board.seconds
    # a part that sleeps tells of no data, so that nobody asks for any
    running.board.run_until(lambda: losses(running) == 1, 0.3, step_s=1e-4)
    assert running.board.seconds - reset_s <= 0.020
    running.board.run_until(lambda: running.number("state", 1) == RUNNING, 0.5)
    assert running.board.seconds - reset_s < 0.5
    count = running.number("sample_count", 4)
    running.board.run(0.1)
    assert running.number("sample_count", 4) - count == pytest.approx(running.rate_hz / 10, abs=2)


def test_unplugged_it_is_absent_and_back_within_half_a_second(running):
    running.board.run(0.1)
    running.board.imu.unplug()
    gone_s = running.board.seconds
    running.board.run_until(lambda: running.number("state", 1) == ABSENT, 0.3, step_s=1e-4)
    assert running.board.seconds - gone_s <= 0.020
    running.board.run(1.0)
    assert losses(running) == 1
    assert running.board.stats["twi_nacks"] <= 8  # five a second
    running.board.imu.plug()
    back_s = running.board.seconds
    count = running.number("sample_count", 4)
    running.board.run_until(lambda: running.number("sample_count", 4) > count, 1.0)
    assert running.board.seconds - back_s < 0.5


def test_a_stuck_bus_is_recovered_and_the_samples_go_on(running):
    running.board.run(0.1)
    running.board.bus.fault("sda_stuck", clocks=9)
    count, stuck_s = running.number("sample_count", 4), running.board.seconds
    running.board.run_until(lambda: running.number("recoveries") == 1, 0.1, step_s=1e-4)
    assert running.board.seconds - stuck_s <= 0.020
    running.board.run(0.6)
    assert running.number("state", 1) == RUNNING
    assert running.number("sample_count", 4) - count > 0.25 * running.rate_hz
    assert running.number("recoveries") == 1


def test_no_part_at_all_is_asked_five_times_a_second(motion):
    with motion.board.profile() as profile:
        motion.board.run(2.0)
    assert motion.number("state", 1) == ABSENT
    assert motion.number("identity", 1) == 0
    assert motion.board.stats["twi_starts"] == pytest.approx(10, abs=1)
    assert profile.cpu_load < 0.01


def stamps_of(motion, seconds):
    """All that come in that time."""
    before, stamps = motion.number("sample_count", 4), []
    until_s = motion.board.seconds + seconds
    while motion.board.seconds < until_s:
        motion.board.run(8 / motion.rate_hz)
        fresh = motion.number("sample_count", 4) - before
        before += fresh
        stamps += [each[-1] for each in taken(motion)[-fresh:]] if fresh else []
    return np.array(stamps)


@pytest.mark.parametrize("clock_ppm", [-10_000, 10_000])
def test_an_edge_of_int_paces_whatever_the_parts_clock(motion, clock_ppm):
    motion.board.imu.fit(clock_ppm=clock_ppm)
    motion.board.run(0.3)
    period_us = 1e6 / motion.rate_hz / (1 + clock_ppm * 1e-6)
    with motion.board.profile() as profile:
        steps = np.diff(stamps_of(motion, 2.0))
    assert np.abs(steps - period_us).max() <= 10
    assert "TIMER1_COMPA" not in profile.handlers
    assert overruns(motion) == losses(motion) == 0


def test_without_an_int_wire_the_timer_paces_at_the_nominal_rate(motion):
    motion.board.imu.fit(int_bit=None)
    motion.board.run(0.3)
    steps = np.diff(stamps_of(motion, 5.0))  # 150 turns of the 16-bit timer
    assert len(steps) == pytest.approx(5 * motion.rate_hz, abs=10)
    assert (steps == 1e6 / motion.rate_hz).all()
    assert overruns(motion) == losses(motion) == 0


def test_the_pace_heals_when_the_int_wire_comes_off_and_back(running):
    for wired in (False, True, False, True):
        running.board.imu.wire_int(4 if wired else None)
        steps = np.diff(stamps_of(running, 0.5))
        assert steps.max() <= 2e6 / running.rate_hz  # none is missed at the change
        with running.board.profile() as profile:
            running.board.run(0.1)
        assert ("TIMER1_COMPA" in profile.handlers) != wired
    assert overruns(running) == losses(running) == 0


def test_a_reset_is_seen_without_an_int_wire_before_a_sample_of_zeros_gets_through(motion):
    motion.board.imu.fit(int_bit=None)
    motion.board.run(0.3)
    motion.board.imu.power_cycle()
    reset_s = motion.board.seconds
    motion.board.run_until(lambda: losses(motion) == 1, 0.1, step_s=1e-4)
    assert motion.board.seconds - reset_s <= 0.020
    motion.board.run_until(lambda: motion.number("state", 1) == RUNNING, 0.5)
    motion.board.run(0.1)
    assert all(any(each[:3]) for each in taken(motion))


def test_a_setting_that_changes_by_itself_is_seen_within_20_ms_and_put_right(running):
    """As a sibling does that wakes by itself from a reset: it measures, in other ranges."""
    running.board.run(0.1)
    running.board.imu.set_register(0x1C, 0)
    changed_s = running.board.seconds
    running.board.run_until(lambda: losses(running) == 1, 0.1, step_s=1e-4)
    assert running.board.seconds - changed_s <= 0.020
    running.board.run(0.2)
    assert running.board.imu.registers[0x1C] == 0x18
    assert taken(running)[-1][2] == 2048


def set_mode(motion, mode):
    motion.board.poke(motion.board.symbol("mode"), bytes([mode]))
    motion.board.run(0.3)


def test_the_mode_changes_at_any_time(program):
    motion = in_mode(program, HZ_500)
    motion.board.imu.fit()
    motion.board.run(0.3)
    for number in range(12):  # at another phase of the burst each time
        mode = (HZ_500, HZ_1000)[number % 2]
        set_mode(motion, mode)
        motion.rate_hz = RATES[mode]
        steps = np.diff(stamps_of(motion, 0.1))
        assert np.abs(steps - 1e6 / motion.rate_hz).max() <= 10
        motion.board.run(37e-6 * number)
    assert losses(motion) == motion.number("recoveries") == 0


def test_off_it_lets_the_bus_go_and_comes_back(program):
    motion = in_mode(program, HZ_1000)
    motion.board.imu.fit()
    motion.board.run(0.3)
    set_mode(motion, OFF)
    starts, count = motion.board.stats["twi_starts"], motion.number("sample_count", 4)
    with motion.board.profile() as profile:
        motion.board.run(1.0)
    assert motion.board.stats["twi_starts"] == starts
    assert not {"TWI", "PCINT2", "TIMER1_COMPA"} & set(profile.handlers)
    assert motion.number("state", 1) == ABSENT
    set_mode(motion, HZ_1000)
    assert motion.number("state", 1) == RUNNING
    assert motion.number("sample_count", 4) > count
    assert motion.number("recoveries") == 0


def promised(trim):
    """Self-test answers that the trim codes promise, in the order of a sample."""
    acc = [trim[n] >> 3 & 0x1C | trim[3] >> 4 - 2 * n & 3 for n in range(3)]
    gyro = [trim[n] & 0x1F for n in range(3)]
    acc = [4096 * 0.34 * (0.92 / 0.34) ** ((n - 1) / 30) for n in acc]
    gyro = [25 * 131 * 1.046 ** (n - 1) for n in gyro]
    return np.array([*acc, 0, gyro[0], -gyro[1], gyro[2]])


def test_self_test_and_trim_codes_come_as_samples(program):
    """PS-MPU-6000A-00 rev. 3.4, p. 12: an answer within 14 % of what the codes promise."""
    motion = in_mode(program, SELF_TEST_OFF)
    motion.board.imu.fit(trim=(0x6C, 0x8F, 0xB2, 0x1B))
    rows = []
    for mode in (SELF_TEST_OFF, SELF_TEST_ON, TRIM):
        set_mode(motion, mode)
        rows.append(np.array(taken(motion)[-1][:7]))
    codes = rows[2][:2].astype(">i2").tobytes()  # the part's bytes 0x0D.. in their order
    assert codes == bytes((0x6C, 0x8F, 0xB2, 0x1B))
    wanted = promised(codes)
    axes = [0, 1, 2, 4, 5, 6]
    assert np.abs((rows[1] - rows[0])[axes] / wanted[axes] - 1).max() < 0.14
    assert losses(motion) == 0


def test_the_handlers_stay_within_their_budget(running):
    with running.board.profile() as profile:
        running.board.run(1.0)
        running.board.imu.wire_int(None)
        running.board.run(0.2)
    assert max(each.max_cycles for each in profile.handlers.values()) <= ISR_CYCLES_MAX
    assert profile.irq_off_max.max_cycles <= IRQ_OFF_CYCLES_MAX


def test_a_recording_played_into_the_part_reaches_the_program_sample_by_sample(program):
    folder = os.environ.get("TERAZI_DATA")
    if not folder:
        pytest.skip("TERAZI_DATA is unset: no recording of an IMU to play")
    trial = load_trial(find_trials(Path(folder) / "attitude" / "broad")[0])
    acc, gyro = (each[:1500] for each in (trial.acc_b_counts, trial.gyro_b_counts))
    motion = in_mode(program, HZ_500)
    motion.board.imu.fit()
    motion.board.run(0.2)
    motion.board.imu.play(acc, gyro, np.arange(len(acc)))
    before, seen = motion.number("sample_count", 4), []
    while motion.board.imu.played < len(acc) - 1:
        motion.board.run(0.016)
        fresh = motion.number("sample_count", 4) - before
        before += fresh
        seen += taken(motion)[-fresh:] if fresh else []
    rows = {each[3]: each for each in seen if 0 <= each[3] < len(acc)}
    numbers = sorted(rows)
    assert len(numbers) >= len(acc) - 16
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    wanted = np.hstack([acc, gyro])[numbers]
    got = np.array([[*rows[n][:3], *rows[n][4:7]] for n in numbers])
    assert np.array_equal(got, wanted)
