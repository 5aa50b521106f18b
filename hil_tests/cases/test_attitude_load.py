# SPDX-License-Identifier: MIT
"""Attitude at full rate beside a scale that weighs: nothing late or lost, and time to spare."""

import os
from itertools import pairwise

import pytest

from terazi.link.generated.messages import (
    Attitude,
    ImuStatus,
    Sample,
    SaveSettings,
    SetSetting,
    SettingsState,
    Status,
)
from terazi.link.generated.settings import SettingKey
from virtual_uno.motion import read_motion

SHORT_S, LONG_S = 10.0, 1800.0
WARM_UP_S = 3.0
RATES = {
    "500 Hz, 115 200 baud": ({"IMU_MODE": 1}, 115_200, 500, 350),
    "1 kHz, 500 000 baud": ({"IMU_MODE": 2, "UART_BAUD": 1}, 500_000, 1000, 600),
    "1 kHz, learnt": ({"IMU_MODE": 2, "UART_BAUD": 1, "IMU_ZUPT": 5}, 500_000, 1000, 690),
}


def started(uno, settings, baud):
    virtual = uno.truth("turn itself")
    motion = read_motion("rocking")
    virtual.imu.fit().noise()
    virtual.imu.feel(acc_g=motion.acc_g, gyro_deg_s=motion.gyro_deg_s)
    uno.load(grams=lambda t_s: 250.0 + 200.0 * (t_s % 7.0 > 3.0))
    uno.link.hello()
    for name, value in settings.items():
        key = SettingKey[name]
        uno.link.command(SetSetting(key, value))
    uno.link.command(SaveSettings())
    while uno.link.status().settings_state == SettingsState.WRITING:
        uno.wait(0.1)
    virtual.uart.host_baud = baud
    uno.reset()
    uno.wait(WARM_UP_S)
    return virtual


def of_kind(received, kind):
    return [one.message for one in received if isinstance(one.message, kind)]


def assert_in_a_row(numbers, step=1):
    assert all((new - old) % 65536 == step for old, new in pairwise(numbers))


def hold_out(uno, seconds, settings, baud, rate_hz, busy_permille):
    """For so long nothing is lost or late, and the chip has time left."""
    virtual = started(uno, settings, baud)
    lost_before = uno.link.stream.frames_lost, uno.link.stream.frames_bad
    unread_before = virtual.imu.stats["samples_unread"]  # replaced by the next one: a period late
    left_s = seconds
    while left_s > 0:
        received = uno.wait(min(left_s, 10.0))
        left_s -= 10.0
        assert_in_a_row([one.conversion for one in of_kind(received, Sample)])
        attitudes = of_kind(received, Attitude)
        assert_in_a_row([one.sample for one in attitudes], step=5)
        assert len(attitudes) >= 0.98 * rate_hz / 5 * min(seconds, 10.0)
        health = of_kind(received, ImuStatus)[-1]
        assert (health.missed, health.overruns, health.losses) == (0, 0, 0)
        for status in of_kind(received, Status):
            assert status.cpu_busy_permille <= busy_permille
            assert status.tx_frames_dropped == status.conversions_missed == 0
    assert virtual.imu.stats["samples_unread"] == unread_before
    assert (uno.link.stream.frames_lost, uno.link.stream.frames_bad) == lost_before


@pytest.mark.parametrize("rate", RATES)
def test_at_full_rate_nothing_is_late_or_lost_and_the_chip_has_time_left(uno, rate):
    hold_out(uno, SHORT_S, *RATES[rate])


@pytest.mark.skipif("TERAZI_LONG" not in os.environ, reason="TERAZI_LONG is unset: half an hour")
@pytest.mark.parametrize("rate", RATES)
def test_for_half_an_hour_nothing_is_late_or_lost(uno, rate):
    hold_out(uno, LONG_S, *RATES[rate])
