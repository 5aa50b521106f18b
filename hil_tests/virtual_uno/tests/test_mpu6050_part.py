# SPDX-License-Identifier: GPL-3.0-or-later
"""The simulated MPU-6050, held to its register map (rev. 4.2) and specification (rev. 3.4)."""

import itertools
import math

import numpy as np
import pytest

IMU = 0x68
SMPLRT_DIV, CONFIG, GYRO_CONFIG, ACCEL_CONFIG = 0x19, 0x1A, 0x1B, 0x1C
FIFO_EN, INT_PIN_CFG, INT_ENABLE, INT_STATUS = 0x23, 0x37, 0x38, 0x3A
ACCEL_XOUT_H, TEMP_OUT_H, SIGNAL_PATH = 0x3B, 0x41, 0x68
USER_CTRL, PWR_MGMT_1, PWR_MGMT_2, FIFO_COUNTH, FIFO_R_W = 0x6A, 0x6B, 0x6C, 0x72, 0x74
WHO_AM_I = 0x75
PIND = 0x29


@pytest.fixture
def imu(bus):
    """The agent with a part on its bus; the part itself is ``imu.board.imu``."""
    bus.board.imu.fit()
    return bus


def write(bus, reg, *values):
    bus.transfer(IMU, (reg, *values))


def read(bus, reg, n=1):
    data = bus.transfer(IMU, (reg,), n)
    return data[0] if n == 1 else data


def words(data):
    return [int.from_bytes(data[at : at + 2], "big", signed=True) for at in range(0, len(data), 2)]


def wake(bus, *, dlpf=1, divider=0, gyro_range=3, acc_range=3):
    """As a driver does; then the gyroscope's 30 ms."""
    for reg, value in (
        (PWR_MGMT_1, 1),
        (SMPLRT_DIV, divider),
        (CONFIG, dlpf),
        (GYRO_CONFIG, gyro_range << 3),
        (ACCEL_CONFIG, acc_range << 3),
    ):
        write(bus, reg, value)
    bus.board.run(0.05)


def burst(bus):
    """acc, temperature, gyro as 7 words."""
    return words(read(bus, ACCEL_XOUT_H, 14))


def test_part_answers_0x68_and_sleeps_with_reset_values(imu):
    assert read(imu, WHO_AM_I) == 0x68
    assert read(imu, PWR_MGMT_1) == 0x40
    assert [read(imu, reg) for reg in (SMPLRT_DIV, CONFIG, GYRO_CONFIG, USER_CTRL)] == [0] * 4
    imu.board.run(0.1)
    assert burst(imu) == [0] * 7  # asleep: nothing is measured
    assert imu.board.imu.stats["samples"] == 0


@pytest.mark.parametrize("identity", [0x98, 0x72, 0x70])
def test_part_can_be_one_of_the_siblings(bus, identity):
    bus.board.imu.fit(who_am_i=identity)
    assert read(bus, WHO_AM_I) == identity


def test_burst_of_14_bytes_takes_390_us_at_400_khz(imu):
    wake(imu)
    burst(imu)
    bits = 3 + 17 * 9  # START, repeated START, STOP; two addresses, the register, 14 bytes
    assert bits * 2.5e-6 == pytest.approx(390e-6)
    polling_s = 20 * 60 / 16e6  # the agent takes up to 60 cycles between two of the 20 steps
    assert 390e-6 <= imu.seconds <= 390e-6 + polling_s


def test_registers_count_on_and_read_only_ones_stay(imu):
    write(imu, SMPLRT_DIV, 7, 3, 0x18, 0x10)
    assert read(imu, SMPLRT_DIV, 4) == bytes([7, 3, 0x18, 0x10])
    write(imu, WHO_AM_I, 0x11)
    assert read(imu, WHO_AM_I) == 0x68
    write(imu, ACCEL_XOUT_H, 0x11)
    assert read(imu, ACCEL_XOUT_H) == 0


@pytest.mark.parametrize(("gyro_range", "counts"), list(enumerate([131.0, 65.5, 32.8, 16.4])))
def test_gyroscope_has_its_ranges(imu, gyro_range, counts):
    imu.board.imu.feel(gyro_deg_s=(10.0, -20.0, 100.0))
    wake(imu, gyro_range=gyro_range)
    assert burst(imu)[4:] == [round(10 * counts), round(-20 * counts), round(100 * counts)]


@pytest.mark.parametrize("acc_range", range(4))
def test_accelerometer_has_its_ranges_and_saturates(imu, acc_range):
    full_g = 2 << acc_range
    imu.board.imu.feel(acc_g=(0.5, full_g + 1, -full_g - 1))
    wake(imu, acc_range=acc_range)
    assert burst(imu)[:3] == [round(0.5 * 16384 / (1 << acc_range)), 32767, -32768]


@pytest.mark.parametrize("degrees", [-40.0, 25.0, 36.53, 85.0])
def test_temperature_follows_the_formula_of_the_register_map(imu, degrees):
    imu.board.imu.feel(temperature_c=degrees)
    wake(imu)
    raw = words(read(imu, TEMP_OUT_H, 2))[0]
    assert raw / 340 + 36.53 == pytest.approx(degrees, abs=0.5 / 340 + 1e-9)


def test_temperature_can_be_a_function_of_time(imu):
    imu.board.imu.feel(temperature_c=lambda t: 20 + 10 * t)
    wake(imu)
    imu.board.run(1.0)
    now_s = imu.board.seconds
    raw = words(read(imu, TEMP_OUT_H, 2))[0]
    assert raw / 340 + 36.53 == pytest.approx(20 + 10 * now_s, abs=0.03)


@pytest.mark.parametrize(
    ("dlpf", "divider", "rate_hz"),
    [(1, 0, 1000), (3, 1, 500), (6, 9, 100), (0, 7, 1000), (0, 0, 8000), (7, 79, 100)],
)
def test_sample_rate_is_the_gyroscopes_over_one_and_the_divider(imu, dlpf, divider, rate_hz):
    wake(imu, dlpf=dlpf, divider=divider)
    before = imu.board.imu.stats["samples"]
    imu.board.run(1.0)
    assert imu.board.imu.stats["samples"] - before == pytest.approx(rate_hz, abs=1)


def test_its_own_clock_may_be_off(bus):
    bus.board.imu.fit(clock_ppm=10_000)
    wake(bus)
    before = bus.board.imu.stats["samples"]
    bus.board.run(1.0)
    assert bus.board.imu.stats["samples"] - before == pytest.approx(1010, abs=1)


@pytest.mark.parametrize(
    ("dlpf", "acc_ms", "gyro_ms"), [(1, 2.0, 1.9), (2, 3.0, 2.8), (3, 4.9, 4.8)]
)
def test_low_pass_filter_delays_as_the_register_map_says(imu, dlpf, acc_ms, gyro_ms):
    """A ramp of 1 count a millisecond shows its delay in counts."""
    imu.board.imu.feel(
        acc_g=lambda t: np.outer(t, (1000 / 2048, 0, 0)),
        gyro_deg_s=lambda t: np.outer(t, (1000 / 16.4, 0, 0)),
        temperature_c=lambda t: 36.53 + t * 1000 / 340,
    )
    wake(imu, dlpf=dlpf)
    imu.board.run(0.5)
    acc, _, _, now, gyro, _, _ = burst(imu)
    assert now - acc == pytest.approx(acc_ms, abs=1)
    assert now - gyro == pytest.approx(gyro_ms, abs=1)


def test_rates_are_zero_until_the_gyroscope_has_started(imu):
    imu.board.imu.feel(gyro_deg_s=(100.0, 0, 0))
    write(imu, CONFIG, 1)
    write(imu, PWR_MGMT_1, 1)
    imu.board.run(0.02)
    assert burst(imu)[4] == 0
    imu.board.run(0.02)
    assert burst(imu)[4] == 13_100


def test_noise_has_the_density_of_the_specification(imu):
    imu.board.imu.noise()
    imu.board.imu.feel(acc_g=(0, 0, 0))
    wake(imu, dlpf=3, gyro_range=0, acc_range=0)
    samples = np.array([burst(imu) for _ in range(400) if imu.board.run(0.002) is None], float)
    gyro, acc = samples[:, 4:] / 131.0, samples[:, :3] / 16384.0
    assert gyro.std() == pytest.approx(0.005 * math.sqrt(42 * math.pi / 2), rel=0.1)
    assert acc.std() == pytest.approx(400e-6 * math.sqrt(44 * math.pi / 2), rel=0.1)
    assert abs(gyro.mean()) < 0.005


def test_errors_of_a_board_come_on_top(imu):
    imu.board.imu.errors(
        gyro_bias_deg_s=(5.0, -5.0, 0),
        gyro_per_g=0.1,
        acc_offset_g=(0.05, 0, -0.08),
        acc_matrix=np.eye(3) * 1.03,
        acc_offset_per_k=(0.001, 0, 0),
    )
    imu.board.imu.feel(acc_g=(0, 0, 1.0), temperature_c=35.0)
    wake(imu)
    acc_x, _, acc_z, _, gyro_x, gyro_y, gyro_z = burst(imu)
    assert (acc_x, acc_z) == (round(0.06 * 2048), round(0.95 * 2048))
    assert (gyro_x, gyro_y, gyro_z) == (82, -82, round(0.1 * 16.4))


def test_played_rows_come_one_a_sample_and_the_last_is_held(imu):
    rows = np.arange(30).reshape(10, 3)
    wake(imu, divider=9)  # 100 Hz
    imu.board.imu.play(rows, rows + 1000, np.arange(10))
    seen = []
    while imu.board.imu.played < 9:
        imu.board.run(0.005)
        seen.append(tuple(burst(imu)))
    imu.board.run(0.1)
    wanted = [(*a, n, *g) for n, (a, g) in enumerate(zip(rows, rows + 1000, strict=True))]
    distinct = list(dict.fromkeys(seen))
    assert [each for each in distinct if each[4] >= 1000] == [
        tuple(int(v) for v in each) for each in wanted[:9]
    ]
    assert tuple(burst(imu)) == tuple(int(v) for v in wanted[-1])
    imu.board.imu.play(None, None)
    imu.board.run(0.05)
    assert burst(imu)[2] == 2048


def test_fifo_gathers_what_it_is_told_to_and_drops_the_oldest(imu):
    wake(imu, divider=9)
    imu.board.imu.play(np.zeros((200, 3), int), np.arange(600).reshape(200, 3))
    write(imu, FIFO_EN, 0x70)  # gyroscope
    write(imu, USER_CTRL, 0x44)  # on, emptied
    imu.board.run(0.1)
    count = int.from_bytes(read(imu, FIFO_COUNTH, 2), "big")
    assert count % 6 == 0
    assert 54 <= count <= 66
    first, second = (words(read(imu, FIFO_R_W, 6)) for _ in range(2))
    assert np.diff([first, second], axis=0).tolist() == [[3, 3, 3]]
    assert int.from_bytes(read(imu, FIFO_COUNTH, 2), "big") == count - 12
    read(imu, INT_STATUS)
    imu.board.run(2.0)  # 6 bytes at 100 Hz: full after 1.7 s
    assert int.from_bytes(read(imu, FIFO_COUNTH, 2), "big") == 1024
    assert read(imu, INT_STATUS) & 0x10
    assert imu.board.imu.stats["fifo_lost"] > 0
    write(imu, USER_CTRL, 0x04)
    assert read(imu, FIFO_COUNTH, 2) == b"\0\0"


def test_int_pin_tells_of_each_sample(imu):
    def int_level():
        return imu.board.peek(PIND)[0] >> 4 & 1

    wake(imu, divider=9)
    write(imu, INT_ENABLE, 1)
    seen = [int_level() for _ in range(4000) if imu.board.run(25e-6) is None]
    edges = sum(b > a for a, b in itertools.pairwise(seen))
    assert edges == pytest.approx(10, abs=1)
    assert sum(seen) == pytest.approx(2 * edges, abs=edges / 2)  # 50 us high
    write(imu, INT_PIN_CFG, 0xA0)  # latched, active low
    read(imu, INT_STATUS)
    assert int_level() == 1
    imu.board.run(0.02)
    assert int_level() == 0
    assert read(imu, INT_STATUS) & 1
    assert read(imu, INT_STATUS) & 1 == 0
    assert int_level() == 1


def test_self_test_adds_what_the_trim_codes_promise(imu):
    wake(imu, gyro_range=0, acc_range=2)
    still = np.array(burst(imu))
    write(imu, GYRO_CONFIG, 0xE0)
    write(imu, ACCEL_CONFIG, 0xF0)
    imu.board.run(0.05)
    answer = np.array(burst(imu)) - still
    trim = read(imu, 0x0D, 4)
    gyro_code, acc_code = trim[0] & 0x1F, trim[0] >> 3 & 0x1C | trim[3] >> 4 & 3
    gyro = 25 * 131 * 1.046 ** (gyro_code - 1)
    acc = 4096 * 0.34 * (0.92 / 0.34) ** ((acc_code - 1) / 30)
    assert answer[4:] == pytest.approx([gyro, -gyro, gyro], abs=1)
    assert answer[:3] == pytest.approx([acc] * 3, abs=1)


def test_standby_and_a_disabled_thermometer_keep_their_last_value(imu):
    wake(imu)
    write(imu, PWR_MGMT_2, 0x04)  # the gyroscope's x
    write(imu, PWR_MGMT_1, 0x09)
    imu.board.imu.feel(gyro_deg_s=(50, 50, 50), temperature_c=60.0)
    imu.board.run(0.05)
    _, _, _, warm, x, y, _ = burst(imu)
    assert (x, y) == (0, 820)
    assert warm == round((25 - 36.53) * 340)


def test_reset_in_mid_flight_puts_it_back_to_sleep(imu):
    wake(imu)
    imu.board.imu.power_cycle()
    assert read(imu, PWR_MGMT_1) == 0x40
    assert read(imu, SMPLRT_DIV, 4) == bytes(4)
    wake(imu)
    write(imu, PWR_MGMT_1, 0x80)
    assert read(imu, PWR_MGMT_1) == 0x40
    wake(imu)
    write(imu, SIGNAL_PATH, 7)
    assert burst(imu) == [0] * 7 or burst(imu)[2] == 2048  # cleared until the next sample


def test_unplugged_it_answers_to_nothing_and_comes_back_asleep(imu):
    wake(imu)
    imu.board.imu.unplug()
    with pytest.raises(OSError, match="32"):  # 0x20: address not acknowledged
        read(imu, WHO_AM_I)
    imu.board.imu.plug()
    assert read(imu, PWR_MGMT_1) == 0x40


def test_a_deaf_bus_acknowledges_nothing(imu):
    imu.board.bus.fault("deaf")
    with pytest.raises(OSError, match="32"):
        read(imu, WHO_AM_I)
    imu.board.bus.clear_faults()
    assert read(imu, WHO_AM_I) == 0x68


@pytest.mark.parametrize("line", ["sda_stuck", "scl_stuck"])
def test_a_line_held_low_keeps_the_start_from_happening_until_it_is_let_go(imu, line):
    imu.board.bus.fault(line)
    with pytest.raises(TimeoutError):
        read(imu, WHO_AM_I)
    assert imu.board.bus.is_stuck
    imu.board.bus.clear_faults()
    imu.board.run(0.001)
    assert imu._get("go") == b"\0"
    assert imu._get("buffer", 1) == b"\x68"


def test_what_is_no_part_is_refused(bus):
    with pytest.raises(ValueError, match="no bus fault"):
        bus.board.bus.fault("wet")
    with pytest.raises(ValueError, match="shape"):
        bus.board.imu.play(np.zeros((3, 3)), np.zeros((4, 3)))
    with pytest.raises(ValueError, match="16 bits"):
        bus.board.imu.play(np.full((1, 3), 40_000), np.zeros((1, 3)))
    with pytest.raises(ValueError, match="no magnetometer"):
        bus.board.mag.fit("compass")
