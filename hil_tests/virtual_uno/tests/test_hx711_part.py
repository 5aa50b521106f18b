# SPDX-License-Identifier: GPL-3.0-or-later
"""The HX711 alone, driven by edges at 1 ns ticks: what its datasheet (p. 4..6) says."""

import pytest

from virtual_uno import Hx711

NS = 1e9
US = 1000  # ticks
RATE_SPS = 80.0
PERIOD = round(NS / RATE_SPS)


class Reader:
    """A careful microcontroller: 1 us high, 1 us low."""

    def __init__(self, *, counts=0.0, high=US, low=US):
        self.part = Hx711(NS, rate_sps=RATE_SPS, counts=counts)
        self.high, self.low = high, low
        self.now = 0

    def wait(self, ticks):
        self.now += ticks
        self.part.advance(self.now)

    def wait_ready(self):
        limit = self.now + 10 * PERIOD
        while self.part.dout:
            assert self.now < limit, "DOUT never fell"
            self.wait(10 * US)

    def pulse(self):
        self.part.sck(self.now, 1)
        self.wait(self.high)
        self.part.sck(self.now, 0)
        bit = self.part.dout
        self.wait(self.low)
        return bit

    def frame(self, pulses=25):
        self.wait_ready()
        return [self.pulse() for _ in range(pulses)]

    def skip_settling(self):
        for _ in range(4):
            self.frame()

    def counts(self, pulses=25):
        return value(self.frame(pulses))


def value(bits):
    word = sum(bit << (23 - i) for i, bit in enumerate(bits[:24]))
    return word - (1 << 24) if word & 0x800000 else word


@pytest.mark.parametrize("counts", [0, 1, -1, 0x123456, -0x123456, 0x7FFFFF, -0x800000])
def test_frame_carries_24_bits_twos_complement_msb_first(counts):
    reader = Reader(counts=counts)
    reader.skip_settling()
    assert reader.counts() == counts


@pytest.mark.parametrize(("counts", "read"), [(1e8, 0x7FFFFF), (-1e8, -0x800000)])
def test_converter_saturates(counts, read):
    reader = Reader(counts=counts)
    reader.skip_settling()
    assert reader.counts() == read


def test_dout_is_high_from_pulse_25_until_the_next_conversion():
    reader = Reader(counts=0)
    reader.skip_settling()
    bits = reader.frame(27)
    assert bits[:24] == [0] * 24
    assert bits[24:] == [1, 1, 1]
    assert reader.part.dout == 1
    reader.wait_ready()
    assert reader.now >= PERIOD


def test_data_come_within_t2_and_not_before():
    reader = Reader(counts=0x555555)
    reader.skip_settling()
    reader.wait_ready()
    for pulse in range(1, 25):
        before = reader.part.dout
        reader.part.sck(reader.now, 1)
        reader.wait(99)
        assert reader.part.dout == before
        reader.wait(1)
        assert reader.part.dout == (0x555555 >> (24 - pulse)) & 1
        reader.wait(US)
        reader.part.sck(reader.now, 0)
        reader.wait(US)


def test_first_four_conversions_after_power_up_are_visibly_wrong():
    reader = Reader(counts=1000)
    errors = [abs(reader.counts() - 1000) for _ in range(6)]
    assert min(errors[:4]) > 10000
    assert errors == sorted(errors, reverse=True)
    assert errors[4:] == [0, 0]
    assert list(reader.part.records["settling"]) == [1, 1, 1, 1, 0, 0]


@pytest.mark.parametrize(("pulses", "gain"), [(26, 32), (27, 64)])
def test_pulses_choose_gain_and_a_change_settles_anew(pulses, gain):
    reader = Reader(counts=128000)
    reader.skip_settling()
    assert reader.counts(pulses) == 128000  # the choice is for the next conversion
    values = [reader.counts(pulses) for _ in range(6)]
    assert all(abs(v - 1000 * gain) > 500 for v in values[:4])
    assert values[4:] == [1000 * gain] * 2
    assert set(reader.part.records["gain"][-6:]) == {gain}


def test_power_down_takes_more_than_60_us_and_loses_the_gain():
    reader = Reader(counts=128000)
    reader.skip_settling()
    for _ in range(6):
        reader.counts(27)
    reader.part.sck(reader.now, 1)
    reader.wait(59 * US)
    assert reader.part.stats["power_downs"] == 0
    reader.wait(2 * US)
    assert reader.part.stats["power_downs"] == 1
    assert reader.part.dout == 1
    reader.wait(10 * PERIOD)  # asleep: nothing converts
    conversions = reader.part.stats["conversions"]
    reader.part.sck(reader.now, 0)
    woke = reader.now
    reader.wait_ready()
    assert reader.part.dout_changed_tick - woke == pytest.approx(PERIOD, abs=1)
    assert reader.part.stats["conversions"] == conversions + 1
    values = [reader.counts() for _ in range(5)]
    assert all(abs(v - 128000) > 10000 for v in values[:4])
    assert values[4] == 128000


@pytest.mark.parametrize(
    ("high_us", "too_long", "power_downs"), [(49, 0, 0), (55, 1, 0), (61, 0, 1)]
)
def test_sck_high_of_50_to_60_us_is_counted_as_unspecified(high_us, too_long, power_downs):
    reader = Reader()
    reader.wait_ready()
    reader.high = high_us * US
    reader.pulse()
    stats = reader.part.stats
    assert (stats["sck_high_too_long"], stats["power_downs"]) == (too_long, power_downs)


def test_phases_shorter_than_the_datasheets_are_counted():
    reader = Reader(high=150, low=150)
    reader.wait_ready()
    fell = reader.part.dout_changed_tick
    reader.wait(PERIOD - (reader.now - fell) + 50)  # 50 ns after the next conversion, unread
    assert reader.part.stats["t1_too_short"] == 0
    reader.now = reader.part.records["tick"][-1] + 50
    reader.now = int(reader.now)
    for _ in range(25):
        reader.pulse()
    stats = reader.part.stats
    assert stats["sck_high_too_short"] == 25
    assert stats["sck_low_too_short"] == 24
    assert stats["sck_high_min_ticks"] == stats["sck_low_min_ticks"] == 150


def test_rising_within_t1_after_dout_fell_is_counted():
    reader = Reader()
    reader.wait(PERIOD + 50)
    assert reader.part.dout == 0
    reader.pulse()
    assert reader.part.stats["t1_too_short"] == 1


def test_frames_of_wrong_length_are_counted():
    reader = Reader()
    reader.frame(10)
    reader.wait(PERIOD)
    assert reader.part.stats["frames_short"] == 1
    reader.frame(28)
    reader.wait(PERIOD)
    stats = reader.part.stats
    assert stats["frames_long"] == 1
    assert stats["busy_pulses"] == 1
    assert list(reader.part.records["read"][:2]) == [0, 1]


def test_pulses_while_nothing_is_ready_read_ones_and_are_counted():
    reader = Reader(counts=0)
    assert [reader.pulse() for _ in range(5)] == [1] * 5
    assert reader.part.stats["busy_pulses"] == 5
    assert abs(reader.counts()) > 10000  # the first settling conversion is whole


def test_unread_conversions_are_replaced_and_counted_while_dout_stays_low():
    reader = Reader(counts=0)
    reader.wait_ready()
    reader.wait(3 * PERIOD)
    assert reader.part.dout == 0
    assert reader.part.stats["conversions_missed"] == 3
    assert list(reader.part.records["pulses"]) == [0, 0, 0, 0]


def test_reading_into_a_conversion_spoils_that_sample_and_the_two_after():
    reader = Reader(counts=0x2AAAAA)
    reader.skip_settling()
    assert reader.counts() == 0x2AAAAA
    reader.wait_ready()
    start = reader.part.dout_changed_tick
    reader.now = start + PERIOD - 22 * US  # 11 pulses before the next conversion, 14 after
    reader.part.advance(reader.now)
    mixed = value([reader.pulse() for _ in range(25)])
    stats = reader.part.stats
    assert stats["overruns"] == 1
    assert stats["frames_short"] == 1
    assert mixed != 0x2AAAAA
    stray = reader.counts()  # what was left of the shift register, then ones
    assert stray != 0x2AAAAA
    wrong_gain = reader.counts()
    assert wrong_gain != 0x2AAAAA
    reader.wait(PERIOD)
    assert reader.part.stats["frames_long"] == 1
    assert 64 in reader.part.records["gain"]


def test_rate_is_the_clocks_own_and_not_80():
    part = Hx711(NS, rate_sps=82.02)
    part.advance(round(10 * NS))
    assert part.stats["conversions"] == 820
    assert part.records["tick"][-1] == pytest.approx(820 / 82.02 * NS, abs=2)
