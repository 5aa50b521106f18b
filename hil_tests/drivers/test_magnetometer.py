# SPDX-License-Identifier: MIT
"""magnetometer: a guest on the IMU's bus; readings, ranges, loss and return, and no sample late."""

import pytest

NONE, QMC, HMC = range(3)
ABSENT, RUNNING = 0, 2
HZ_500, HZ_1000 = 1, 2
RATES = {HZ_500: 500, HZ_1000: 1000}
KINDS = {"qmc5883l": QMC, "hmc5883l": HMC}
COUNTS_PER_GAUSS = {"qmc5883l": 3000, "hmc5883l": 1090}
FIELD_UT = (21.0, -33.0, 45.0)


def on_bus(program, mode, work_cycles=0, weigh_cycles=0):
    drivers = ("mpu6050", "mpu6050_motion", "mpu6050_pace", "magnetometer")
    options = {"MODE": mode, "WORK_CYCLES": work_cycles, "WEIGH_CYCLES": weigh_cycles}
    return program("bus.c", drivers, *(f"-D{name}={value}" for name, value in options.items()))


@pytest.fixture(params=KINDS)
def compass(request, program):
    """A board with that magnetometer and no IMU."""
    made = on_bus(program, HZ_1000)
    made.kind = request.param
    made.board.mag.fit(made.kind)
    made.board.mag.feel(FIELD_UT)
    return made


@pytest.fixture
def both(compass):
    compass.board.imu.fit()
    compass.board.run(1.0)
    assert compass.number("kind", 1) == KINDS[compass.kind]
    assert compass.number("state", 1) == RUNNING
    return compass


def field(compass):
    return [compass.number("mag", signed=True, at=2 * axis) for axis in range(3)]


def counts(compass, field_ut):
    return [round(each / 100 * COUNTS_PER_GAUSS[compass.kind]) for each in field_ut]


def readings(compass, seconds):
    before = compass.number("mag_count", 4)
    compass.board.run(seconds)
    return compass.number("mag_count", 4) - before


def test_each_kind_is_told_and_read_to_the_count(both):
    for field_ut in (FIELD_UT, (-1.0, 2.0, -3.0), (120.0, -110.0, 100.0)):
        both.board.mag.feel(field_ut)
        both.board.run(0.2)
        assert field(both) == counts(both, field_ut)


def test_fifty_to_a_hundred_readings_come_a_second(both):
    assert 50 <= readings(both, 4.0) / 4 <= 100
    assert both.number("mag_longest") <= 64


def test_without_an_imu_it_is_read_just_so(compass):
    compass.board.run(1.0)
    assert compass.number("state", 1) == ABSENT
    assert compass.number("kind", 1) == KINDS[compass.kind]
    assert field(compass) == counts(compass, FIELD_UT)
    assert readings(compass, 2.0) / 2 >= 50


@pytest.mark.parametrize("int_bit", [4, None], ids=["int", "timer"])
@pytest.mark.parametrize("mode", RATES, ids=lambda mode: f"{RATES[mode]}hz")
@pytest.mark.parametrize("kind", [*KINDS, None])
def test_no_sample_is_missed_or_late_beside_it_under_load(program, kind, mode, int_bit):
    """0.34 ms of work on a sample and 1.25 ms every 12.5 ms, as filters and a scale take."""
    loaded = on_bus(program, mode, work_cycles=5500, weigh_cycles=20000)
    board = loaded.board
    board.imu.fit(int_bit=int_bit)
    if kind:
        board.mag.fit(kind)
    board.run(1.0)
    samples, unread = board.imu.stats["samples"], board.imu.stats["samples_unread"]
    count = loaded.number("sample_count", 4)
    board.run(4.0)
    if int_bit is not None:  # the timer knows nothing of when the part measures
        assert board.imu.stats["samples_unread"] == unread  # each was read before the next one
    taken = loaded.number("sample_count", 4) - count
    assert abs(taken - (board.imu.stats["samples"] - samples)) <= 1
    assert loaded.number("counters") == loaded.number("counters", at=2) == 0
    assert loaded.number("stamp_longest") <= 1.01e6 / RATES[mode]
    assert kind is None or readings(loaded, 2.0) / 2 >= 50


def test_a_field_beyond_its_range_is_refused(both):
    beyond_ut = 1200.0 if both.kind == "qmc5883l" else 200.0
    for axis in range(3):
        both.board.mag.feel([beyond_ut if n == axis else 10.0 for n in range(3)])
        both.board.run(0.1)
        assert readings(both, 0.5) == 0
        both.board.mag.feel(FIELD_UT)
        both.board.run(0.1)
        assert readings(both, 0.5) >= 25
        assert field(both) == counts(both, FIELD_UT)
    assert both.number("kind", 1) == KINDS[both.kind]


def test_unplugged_it_is_none_and_found_again_within_a_second(both):
    both.board.mag.unplug()
    both.board.run(0.1)
    assert both.number("kind", 1) == NONE
    assert readings(both, 1.0) == 0
    both.board.mag.plug()
    both.board.run(1.0)
    assert both.number("kind", 1) == KINDS[both.kind]
    assert readings(both, 1.0) >= 50
    assert both.number("counters") == both.number("counters", at=2) == 0


def test_a_reset_of_it_yields_no_zeros_and_it_measures_on_within_two_seconds(both):
    both.board.mag.plug()
    for _ in range(80):
        both.board.run(0.025)
        assert field(both) == counts(both, FIELD_UT)
    assert readings(both, 1.0) >= 50
    assert both.number("counters", at=2) == 0


def test_an_imu_that_goes_and_comes_does_not_take_it_along(both):
    both.board.imu.unplug()
    both.board.run(0.1)
    assert both.number("state", 1) == ABSENT
    assert readings(both, 2.0) / 2 >= 50
    both.board.imu.plug()
    both.board.run(0.5)
    assert both.number("state", 1) == RUNNING
    assert readings(both, 1.0) >= 50
    assert both.number("counters", at=2) == 1


@pytest.mark.parametrize("line", ["sda_stuck", "scl_stuck"])
@pytest.mark.parametrize("after_s", [0.0, 0.0003, 0.0007, 0.0041, 0.0137])
def test_a_stuck_bus_is_told_within_20_ms_and_both_come_back(both, line, after_s):
    both.board.run(after_s)
    both.board.bus.fault(line)
    stuck_s = both.board.seconds
    both.board.run_until(lambda: both.number("state", 1) == ABSENT, 0.1, step_s=1e-4)
    assert both.board.seconds - stuck_s <= 0.020
    both.board.run(0.7)
    assert both.number("counters", at=2) == 1
    both.board.bus.clear_faults()
    well_s, count = both.board.seconds, both.number("sample_count", 4)
    both.board.run_until(lambda: both.number("sample_count", 4) > count, 1.0)
    assert both.board.seconds - well_s < 0.5
    both.board.run(1.0)
    assert readings(both, 1.0) >= 50
    assert both.number("state", 1) == RUNNING


def test_no_magnetometer_at_all_costs_ten_addresses_a_second(program):
    alone = on_bus(program, HZ_1000)
    alone.board.run(0.5)
    before = alone.board.stats["twi_starts"]
    with alone.board.profile() as profile:
        alone.board.run(2.0)
    assert alone.number("kind", 1) == NONE
    assert (alone.board.stats["twi_starts"] - before) / 2 == pytest.approx(10, abs=1)  # IMU's half
    assert profile.cpu_load < 0.01


def test_handlers_and_critical_sections_stay_within_their_budget(both):
    with both.board.profile() as profile:
        both.board.run(2.0)
    assert max(each.max_cycles for each in profile.handlers.values()) <= 200
    assert profile.irq_off_max.max_cycles <= 40
    assert profile.cpu_load < 0.30  # both drivers, and no work on what they give
