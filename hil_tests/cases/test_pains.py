# SPDX-License-Identifier: MIT
"""What users report of the common HX711 libraries, pain by pain: none of it here."""

import numpy as np
import pytest

from terazi.errors import CommandRefused
from terazi.link.generated.messages import (
    CalibrateBegin,
    CalibrateEnd,
    CalibrateKnown,
    ConverterState,
    FaultFlag,
    GetInfo,
    Result,
    Sample,
    SetSetting,
    SetTextMode,
    Setting,
    Status,
    Tare,
    Weight,
    WeightFlag,
    Zero,
)
from terazi.link.generated.settings import SettingKey

E_MG = 1000
NOISY = pytest.mark.board(noise_counts=38.7)
GAINS = {128: 1, 32: 2, 64: 3}  # gain: value of the setting; 32 is channel B
NUMBERS = ("net_mg", "zero_mg", "tare_mg", "shown", "pieces")


def of(kind, received):
    return [one.message for one in received if isinstance(one.message, kind)]


def weights(uno, seconds):
    return of(Weight, uno.wait(seconds))


def stable(messages):
    return [one for one in messages if WeightFlag.STABLE in one.weight_flags]


def status(uno):
    return uno.link.ask(GetInfo(), Status)


def put(uno, key, value):
    uno.link.ask(SetSetting(key, value), Setting, key=key)


# --- 1: spikes of 2^k - 1 ---


@NOISY
def test_pain_1_no_interrupt_stretches_a_clock_pulse(uno):
    """While the line is full both ways, which is when interrupts come most often."""
    virtual = uno.truth("tell how long its clock pulses were")
    uno.link.hello()
    uno.samples(20)
    for _ in range(40):
        uno.write(bytes(range(1, 256)))
        uno.wait(0.02)
    told = virtual.stats["hx711"]
    assert told["sck_high_max_ticks"] <= 5 * 16, "5 us; 50 are the limit"
    assert told["power_downs"] == 1, "the one at the start"


@NOISY
@pytest.mark.parametrize("bit", [2, 6, 12, 20])
def test_pain_1_a_spike_for_all_that_is_no_stable_weight(uno, bit):
    virtual = uno.truth("stretch its clock pulses")
    uno.load(grams=500.0)
    uno.link.hello()
    uno.wait(3.0)
    for _ in range(6):
        uno.fault("stretched", bit=bit, frames=1)
        received = uno.wait(1.5)
        load_mg = 500_000
        shown = stable(of(Sample, received) + of(Weight, received))
        assert all(abs(one.net_mg - shown[0].net_mg) <= E_MG for one in shown)
        assert all(abs(one.mass_mg - load_mg) <= E_MG for one in stable(of(Sample, received)))
    assert virtual.stats["hx711"]["power_downs"] >= 7
    assert stable(weights(uno, 1.0))


# --- 2: interrupts off for a whole frame lose serial bytes ---


@NOISY
def test_pain_2_reading_the_converter_loses_no_serial_byte(uno):
    virtual = uno.truth("count what it receives")
    uno.link.hello()
    before = virtual.stats["rx_bytes"]
    for _ in range(60):
        uno.write(b"\0" * 100)
        uno.wait(0.01)
    with virtual.profile(["hx711_read"]) as profile:
        virtual.run(1.0)
    assert status(uno).rx_overruns == 0
    assert virtual.stats["rx_bytes"] - before >= 6000
    assert virtual.stats["rx_overruns"] == 0
    windows = [one for one in profile.figures.windows if one.begin.startswith("hx711_read")]
    assert 0 < max(one.max_cycles for one in windows) <= 10


# --- 3 and 4: nothing connected ---


@NOISY
def test_pain_3_a_cable_that_is_out_hangs_nothing(uno):
    uno.link.hello()
    uno.samples(20)
    uno.fault("cable_out")
    uno.wait(3.0)
    before = status(uno)
    uno.wait(2.0)
    after = status(uno)
    assert after.uptime_s >= before.uptime_s + 2
    assert after.converter_state == ConverterState.TIMED_OUT
    assert after.cpu_busy_permille < 100


@pytest.mark.parametrize("wires", ["cable_out", "dout_high", "dout_low"])
def test_pain_4_nothing_connected_is_a_fault_and_not_a_weight(uno, wires):
    uno.fault(wires)
    uno.truth("start without a converter").reset("power_on")
    received = uno.wait(3.0)
    assert not of(Sample, received), "neither 0 nor -1"
    assert not stable(of(Weight, received))
    named = FaultFlag.DOUT_STUCK if wires == "dout_low" else FaultFlag.CABLE_OUT
    assert named in status(uno).faults


# --- 5: drift ---


@NOISY
def test_pain_5_a_zero_that_creeps_is_followed(uno):
    """0.6 e a minute, as while a cell warms up."""
    uno.load(grams=lambda t_s: 0.01 * np.maximum(t_s - 4.0, 0.0))
    uno.link.hello()
    uno.wait(4.0)
    shown = weights(uno, 180.0)
    assert max(abs(one.net_mg) for one in shown) <= E_MG // 4
    assert shown[-1].zero_mg > 1.5 * E_MG


# --- 6: zero and calibration lost ---


@NOISY
def test_pain_6_zero_and_calibration_outlive_the_power(uno):
    virtual = uno.truth("cut its power")
    uno.load(grams=40.0)
    uno.link.hello()
    uno.wait(3.0)
    calibrate(uno, [(0, 0), (429_550 * 128, 500_000)])  # half the factory's mass a count
    uno.wait(3.0)
    uno.link.command(Zero())
    uno.wait(4.0)
    before = weights(uno, 1.0)[-1]
    assert abs(before.zero_mg - 20_000) <= E_MG // 2
    virtual.reset("power_on")
    uno.link.hello()
    uno.wait(3.0)
    after = weights(uno, 1.0)[-1]
    assert abs(after.zero_mg - before.zero_mg) <= E_MG // 4
    assert abs(after.net_mg) <= E_MG // 2


# --- 7: 80 SPS never reached ---


@pytest.mark.board(rate_sps=92.0, noise_counts=38.7)
def test_pain_7_no_conversion_is_lost_at_92_sps(uno):
    uno.link.hello()
    uno.wait(1.0)
    numbers = [one.conversion for one in of(Sample, uno.wait(10.0))]
    assert len(numbers) in range(918, 923)
    assert np.all(np.diff(numbers) == 1)
    assert status(uno).conversions_missed == 0


# --- 8: filters that take 2 s ---


@NOISY
def test_pain_8_a_load_is_stable_and_right_within_a_second(uno):
    virtual = uno.truth("place a load at an instant")
    uno.link.hello()
    uno.wait(3.0)
    for grams in (1000.0, 1250.0, 0.0, 4000.0, 20.0):
        virtual.load(grams=grams)
        uno.wait(0.05)
        late = [one for one in of(Sample, uno.wait(0.95))][-1:]
        assert stable(late), f"{grams} g"
        assert abs(late[0].net_mg - grams * 1000) <= E_MG // 2


# --- 9: nan ---


@NOISY
@pytest.mark.parametrize("fault", ["cable_out", "rail", "noise", "frozen"])
def test_pain_9_whatever_fails_numbers_stay_numbers(uno, fault):
    uno.link.hello()
    uno.wait(1.0)
    uno.fault(fault)
    for one in weights(uno, 2.0):
        assert all(isinstance(getattr(one, name), int) for name in NUMBERS)
    uno.link.command(SetTextMode(on=1))
    text = uno.read_raw(1.0).lower()
    assert not any(word in text for word in (b"nan", b"inf", b"ovf"))


# --- 10: the rails ---


@NOISY
@pytest.mark.parametrize("side", ["high", "low"])
def test_pain_10_a_converter_at_its_rail_is_no_weight(uno, side):
    uno.link.hello()
    uno.wait(2.0)
    uno.fault("rail", side=side)
    uno.wait(0.1)
    shown = weights(uno, 2.0)
    assert shown
    assert all(FaultFlag.AT_RAIL in one.faults for one in shown)
    assert not stable(shown)
    with pytest.raises(CommandRefused) as refused:
        uno.link.command(Tare())
    assert refused.value.result == Result.NOT_STABLE


# --- 11: the other channel's sample ---


def assert_only_of(virtual, told, gain, gain_before):
    """No sample but of this gain, settled; or read before the change, which the pulses tell."""
    truth = virtual.conversions[[one.conversion - 1 for one in told]]
    before = truth["pulses"] == 24 + GAINS[gain_before]
    assert before.sum() <= 1, "the one that was on its way when the change was asked for"
    assert set(truth["gain"][~before]) == {gain}
    assert not truth["settling"].any()
    counts = np.array([one.raw_counts for one in told])
    assert np.array_equal(counts, truth["counts"])


@NOISY
@pytest.mark.parametrize("phase", [0.02, 0.35, 0.7, 0.97])
def test_pain_11_after_a_change_of_channel_no_sample_is_of_the_other(uno, phase):
    virtual = uno.truth("tell each conversion's channel")
    uno.load(counts=2_000_000)
    uno.link.hello()
    uno.samples(30)
    gain_before = 128
    for gain in (32, 128, 64, 32, 64, 128):
        next_s = virtual.conversions["time_s"][-1] + (1 + phase) / 80
        uno.wait(next_s - virtual.seconds)
        put(uno, SettingKey.CHAIN_GAIN, GAINS[gain])
        told = of(Sample, uno.wait(0.5))
        assert len(told) > 25, "settling costs five conversions"
        assert_only_of(virtual, told, gain, gain_before)
        gain_before = gain
    assert not status(uno).faults_seen & FaultFlag(0x3F), "a change is no fault"


@pytest.mark.board(rate_sps=10.8, noise_counts=21.5)
def test_pain_11_so_it_is_at_10_sps(uno):
    virtual = uno.truth("tell each conversion's channel")
    uno.load(counts=2_000_000)
    uno.link.hello()
    uno.samples(20)
    gain_before = 128
    for gain in (32, 64, 128):
        put(uno, SettingKey.CHAIN_GAIN, GAINS[gain])
        told = of(Sample, uno.wait(1.5))
        assert len(told) > 8
        assert_only_of(virtual, told, gain, gain_before)
        gain_before = gain


# --- 12: no multi-point calibration ---


def calibrate(uno, points):
    uno.link.command(CalibrateBegin())
    for counts_q7, mass_mg in points:
        uno.link.command(CalibrateKnown(counts_q7, mass_mg))
    uno.link.command(CalibrateEnd())


@NOISY
def test_pain_12_a_cell_that_bows_is_right_after_five_points(uno):
    """0.5 % of bow: 25 g in the middle of 5 kg."""

    def counts(grams):
        share = grams / 5000.0
        return 429.55 * (grams + 0.005 * 5000.0 * 4 * share * (1 - share))

    uno.load(counts=0)
    uno.link.hello()
    points = [(round(counts(grams) * 128), grams * 1000) for grams in range(0, 5001, 1250)]
    calibrate(uno, points)
    for grams in (1250.0, 2500.0, 3750.0, 5000.0):
        uno.load(counts=counts(grams))
        uno.wait(1.5)
        assert abs(weights(uno, 0.5)[-1].net_mg - grams * 1000) <= E_MG // 2
    uno.load(counts=counts(600.0))
    uno.wait(1.5)
    assert abs(weights(uno, 0.5)[-1].net_mg - 600_000) <= 2 * E_MG, "what a fifth of a bow leaves"


# --- 13: no stability flag ---


@NOISY
def test_pain_13_stable_is_told_and_taken_back(uno):
    virtual = uno.truth("move a load")
    uno.link.hello()
    uno.wait(3.0)
    assert stable(weights(uno, 0.5))
    start_s = virtual.seconds_since_reset
    virtual.load(grams=lambda t_s: 300.0 * np.clip(t_s - start_s, 0.0, 2.0))
    uno.wait(0.3)
    assert not stable(weights(uno, 1.5)), "it moves by 300 g a second"
    uno.wait(1.5)
    assert stable(weights(uno, 0.5))
