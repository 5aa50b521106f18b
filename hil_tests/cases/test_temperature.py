# SPDX-License-Identifier: MIT
"""The thermometer beside the scale: a cell that drifts, no part, a bus that is stuck."""

import numpy as np
import pytest

from terazi.link.generated.messages import (
    FaultFlag,
    GetInfo,
    Sample,
    SaveSettings,
    SetSetting,
    Setting,
    Status,
    Weight,
    WeightFlag,
)
from terazi.link.generated.settings import SettingKey

COUNTS_PER_GRAM = 429.55
ZERO, SPAN = 107.0, 80.0  # counts/K, ppm/K: four times what a usual cell's span does
REFERENCE_C = 20.0
COLD_C, WARM_C, COLD_S, WARMING_S = 20.0, 32.0, 12.0, 60.0
LOAD_G = 2000.0
# notes/temperature.md: 0.045 K of zero and span, the second order of both, a share's last bit,
# half a count; and 3 sigma of a mean of 5 counts' noise
HELD_G = (
    0.045 * (ZERO / COUNTS_PER_GRAM + SPAN * 1e-6 * LOAD_G)
    + SPAN * 12e-6 * (ZERO * 12 / COUNTS_PER_GRAM + SPAN * 12e-6 * LOAD_G)
    + 2**-21 * LOAD_G
    + (0.5 + 3 * 5 / 10) / COUNTS_PER_GRAM
)
SETTINGS = {
    SettingKey.TEMPERATURE_REFERENCE_CENTI: round(100 * REFERENCE_C),
    SettingKey.TEMPERATURE_ORIGIN_COUNTS: 0,
    SettingKey.TEMPERATURE_ZERO_COUNTS_PER_K_Q4: round(16 * ZERO),
    SettingKey.TEMPERATURE_SPAN_PPM_PER_K_Q4: round(16 * SPAN),
}


def put(uno, key, value):
    assert uno.link.ask(SetSetting(key, value), Setting, key=key).value == value


def compensate(uno, on):
    for key, value in SETTINGS.items():
        put(uno, key, value)
    put(uno, SettingKey.TEMPERATURE_ON, on)


def status(uno):
    return uno.link.ask(GetInfo(), Status)


def warmth(t_s):
    """Cold for a while, then warming, by less than one reading may move the smoothed one."""
    return np.interp(t_s, [COLD_S, COLD_S + WARMING_S], [COLD_C, WARM_C])


def drifting(t_s):
    """Counts of a cell with 2 kg on it."""
    above_k = warmth(t_s) - REFERENCE_C
    return ZERO * above_k + LOAD_G * COUNTS_PER_GRAM * (1 + SPAN * 1e-6 * above_k)


def masses_g(received):
    return (
        np.array([one.message.mass_mg for one in received if isinstance(one.message, Sample)])
        / 1000
    )


@pytest.mark.parametrize("on", [0, 1])
def test_a_cell_that_drifts_with_warmth_is_held_where_it_was(uno, on):
    board = uno.truth("drift with temperature")
    board.imu.fit()
    board.imu.feel(temperature_c=warmth)
    board.load(counts=drifting)
    uno.link.hello()
    compensate(uno, on)
    cold = masses_g(uno.wait(COLD_S - 1.0))[-160:]
    uno.wait(WARMING_S + 95.0)  # the smoothing lags by 16 s
    warm = masses_g(uno.wait(10.0))[-160:]
    moved_g = warm.mean() - cold.mean()
    drift_g = (ZERO * 12 + LOAD_G * COUNTS_PER_GRAM * SPAN * 12e-6) / COUNTS_PER_GRAM
    if on:
        assert abs(moved_g) <= HELD_G
    else:
        assert moved_g == pytest.approx(drift_g, abs=0.05)  # 4.9 g: the test can fail


def test_the_temperature_is_told_and_none_is_told_as_none(uno):
    board = uno.truth("set its temperature")
    board.imu.fit()
    board.imu.feel(temperature_c=27.5)
    uno.link.hello()
    weights = [one.message for one in uno.wait(4.0) if isinstance(one.message, Weight)]
    assert weights[0].temperature_centi == -(1 << 31)
    assert weights[-1].temperature_centi == pytest.approx(2750, abs=1)
    board.imu.unplug()
    weights = [one.message for one in uno.wait(3.0) if isinstance(one.message, Weight)]
    assert weights[-1].temperature_centi == -(1 << 31)


@pytest.mark.parametrize("trouble", ["no part", "sda_stuck", "scl_stuck", "deaf", "unplugged"])
def test_weighing_goes_on_undisturbed_without_a_thermometer(uno, trouble):
    board = uno.truth("have a bus in trouble")
    if trouble != "no part":
        board.imu.fit()
    uno.link.hello()
    compensate(uno, 1)
    uno.wait(3.0)
    before = status(uno)
    if trouble == "unplugged":
        board.imu.unplug()
    elif trouble != "no part":
        board.bus.fault(trouble)
    received = uno.wait(8.0)
    numbers = [one.message.conversion for one in received if isinstance(one.message, Sample)]
    assert len(numbers) >= 630
    assert np.all(np.diff(numbers) == 1)
    after = status(uno)
    assert FaultFlag.THERMOMETER in FaultFlag(after.faults)
    others = FaultFlag(after.faults) & ~FaultFlag.THERMOMETER
    assert others == (FaultFlag(0) if trouble == "no part" else FaultFlag.IMU_LOST)
    assert after.conversions_missed == before.conversions_missed
    board.bus.clear_faults()
    board.imu.plug()
    if trouble != "no part":
        uno.wait(3.0)
        assert FaultFlag.THERMOMETER not in FaultFlag(status(uno).faults)


def test_without_compensation_nobody_misses_a_thermometer(uno):
    uno.link.hello()
    uno.wait(4.0)
    assert FaultFlag.THERMOMETER not in FaultFlag(status(uno).faults_seen)


def test_no_weight_is_stable_before_the_first_temperature(uno):
    """12 K above the reference, 3 g of drift: what is told as stable after a start is right."""
    board = uno.truth("start warm")
    board.imu.fit()
    board.imu.feel(temperature_c=32.0)
    board.load(counts=12 * ZERO + LOAD_G * COUNTS_PER_GRAM * (1 + SPAN * 12e-6))
    uno.link.hello()
    compensate(uno, 1)
    uno.link.command(SaveSettings())
    uno.wait(1.0)
    uno.reset("power_on")
    uno.link.stream.hello = None
    uno.link.hello()
    told = [one.message for one in uno.wait(6.0) if isinstance(one.message, Sample)]
    stable = [one for one in told if WeightFlag.STABLE in WeightFlag(one.weight_flags)]
    assert len(stable) > 100
    masses = np.array([one.mass_mg for one in stable]) / 1000
    assert np.abs(masses - masses[-1]).max() <= 0.5
