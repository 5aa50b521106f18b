# SPDX-License-Identifier: MIT
"""thermometer and twi: readings, absence, bus faults, and what they cost the main loop."""

import pytest

CALL_MAX_US = 160  # twi.h: a recovery takes 130 us, and interrupts come in between
ISR_CYCLES_MAX = 200


@pytest.fixture
def meter(program):
    return program("thermometer.c", ("thermometer", "mpu6050"))


def settled(meter, seconds=0.5):
    meter.board.run(seconds)
    return meter.number("centi", signed=True)


@pytest.mark.parametrize("degrees", [-39.9, -0.01, 0.0, 21.37, 36.53, 84.9])
def test_thermometer_reads_hundredths_of_a_degree(meter, degrees):
    meter.board.imu.fit()
    meter.board.imu.feel(temperature_c=degrees)
    assert settled(meter) / 100 == pytest.approx(degrees, abs=0.0075)  # 1/340 K and two roundings


def test_thermometer_gives_nothing_of_a_part_that_still_sleeps(meter):
    """TEMP_OUT of a sleeping part is 0, which is 36.53 degC and no temperature."""
    meter.board.imu.fit()
    meter.board.imu.feel(temperature_c=20.0)
    meter.board.run_until(lambda: meter.number("readings") == 1, 1.0)
    assert meter.number("centi", signed=True) == 2000
    for _ in range(5):
        meter.board.imu.power_cycle()
        before = meter.number("readings")
        meter.board.run_until(lambda b=before: meter.number("readings") != b, 1.0, step_s=1e-4)
        assert meter.number("centi", signed=True) == 2000
    assert meter.number("missing") == 0


def test_no_part_is_told_once_a_round_and_costs_next_to_nothing(meter):
    with meter.board.profile() as profile:
        meter.board.run(2.05)
    assert meter.number("missing") == pytest.approx(20, abs=1)
    assert meter.number("readings") == 0
    assert meter.board.stats["twi_starts"] == meter.number("missing")
    assert meter.number("recoveries") == 0
    assert meter.number("longest_ticks") / 2 < 60
    assert profile.cpu_load < 0.01


@pytest.mark.parametrize("line", ["sda_stuck", "scl_stuck"])
def test_a_line_stuck_for_ever_is_bounded_and_read_again_after_it(meter, line):
    meter.board.imu.fit()
    settled(meter)
    before = meter.number("readings"), meter.number("missing")
    meter.board.bus.fault(line)
    meter.board.run(2.0)
    assert meter.number("readings") - before[0] <= 1
    assert meter.number("missing") - before[1] == pytest.approx(20, abs=1)
    assert meter.number("recoveries") == meter.number("missing") - before[1]
    assert meter.number("longest_ticks") / 2 <= CALL_MAX_US
    meter.board.bus.clear_faults()
    readings = meter.number("readings")
    meter.board.run(0.35)
    assert meter.number("readings") - readings >= 3


@pytest.mark.parametrize("clocks", [1, 9, 20])
def test_a_part_that_holds_sda_is_clocked_free(meter, clocks):
    """A byte that was under way when something reset the master: the part waits for its clocks."""
    meter.board.imu.fit()
    settled(meter)
    meter.board.bus.fault("sda_stuck", clocks=clocks)
    meter.board.run(0.25)
    assert not meter.board.bus.is_stuck
    assert meter.number("recoveries") == 1
    assert meter.board.stats["twi_free_clocks"] == clocks + 1  # and the one of the STOP
    readings = meter.number("readings")
    meter.board.run(0.35)
    assert meter.number("readings") - readings >= 3
    assert meter.number("recoveries") == 1


def test_a_stuck_bus_is_not_clocked_for_ever(meter):
    meter.board.imu.fit()
    settled(meter)
    meter.board.bus.fault("sda_stuck", clocks=100)
    meter.board.run_until(lambda: meter.number("recoveries") == 1, 1.0)
    assert meter.board.stats["twi_free_clocks"] == 21
    meter.board.run_until(lambda: not meter.board.bus.is_stuck, 1.0)  # the fifth time
    assert meter.number("recoveries") == 5


def test_a_line_that_sticks_within_a_transfer_ends_it(meter):
    meter.board.imu.fit()
    settled(meter)
    starts = meter.board.stats["twi_starts"]
    meter.board.run_until(lambda: meter.board.stats["twi_starts"] > starts, 1.0, step_s=2e-6)
    meter.board.run(40e-6)  # the address is on its way or just through
    missing = meter.number("missing")
    meter.board.bus.fault("sda_stuck", clocks=9)
    meter.board.run(0.21)  # this round and the next, which finds it stuck and clocks it free
    assert 1 <= meter.number("missing") - missing <= 2
    assert meter.number("recoveries") == 1
    readings = meter.number("readings")
    meter.board.run(0.35)
    assert meter.number("readings") - readings >= 3


def test_unplugged_and_plugged_again_it_reads_on(meter):
    meter.board.imu.fit()
    settled(meter)
    meter.board.imu.unplug()
    readings = meter.number("readings")
    meter.board.run(0.5)
    assert meter.number("readings") - readings <= 1
    assert meter.number("missing") >= 4
    meter.board.imu.feel(temperature_c=30.0)
    meter.board.imu.plug()
    meter.board.run(0.35)
    assert meter.number("centi", signed=True) == 3000


def test_the_interrupt_handler_stays_within_its_budget(meter):
    meter.board.imu.fit()
    with meter.board.profile() as profile:
        meter.board.run(1.0)
    handler = profile.handlers["TWI"]
    assert handler.calls > 50
    assert handler.max_cycles <= ISR_CYCLES_MAX
