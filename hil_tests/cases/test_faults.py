# SPDX-License-Identifier: MIT
"""What fails is named in time, at both of the converter's rates, and forgotten when it ends."""

import itertools

import pytest

from terazi.link.generated.messages import (
    Fault,
    FaultFlag,
    GetInfo,
    Sample,
    SetSetting,
    Setting,
    Status,
    Weight,
    WeightFlag,
)
from terazi.link.generated.settings import SettingKey

E_MG = 1000
SPOILS = FaultFlag(0x3F)  # the weight; telemetry, settings and thermometer do not
STEP_S = 0.002
RECOVERY_S = 1.0
LAG_S = 0.001  # from the device's knowledge to the host
LOAD_G = 500.0

AT_80 = pytest.mark.board(rate_sps=80.0, noise_counts=38.7)
AT_92 = pytest.mark.board(rate_sps=92.0, noise_counts=38.7)
AT_10 = pytest.mark.board(rate_sps=10.8, noise_counts=21.5)

# Fault of the bench, how, what it is called; those that come once end as they begin.
LASTING = {
    "cable_out": ({}, FaultFlag.CABLE_OUT),
    "dout_high": ({}, FaultFlag.CABLE_OUT),
    "dout_low": ({}, FaultFlag.DOUT_STUCK),
    "rail": ({"side": "high"}, FaultFlag.AT_RAIL),
    "rail_low": ({"side": "low"}, FaultFlag.AT_RAIL),
    "rate": ({"factor": 20.0}, FaultFlag.RATE_OUT_OF_RANGE),
    "noise": ({"counts": 1_000_000.0}, FaultFlag.NOISE_HIGH),
    "frozen": ({}, FaultFlag.DOUT_STUCK),
}
PASSING = {
    "glitch": ({}, FaultFlag.FRAMES_LOST),
    "conversion_lost": ({"count": 1}, FaultFlag.FRAMES_LOST),
    "conversions_lost": ({"count": 3}, FaultFlag.CABLE_OUT | FaultFlag.FRAMES_LOST),
    "bit_lost": ({"bit": 12, "frames": 1}, FaultFlag.FRAMES_LOST),
    "stretched": ({"bit": 5, "frames": 1}, FaultFlag.FRAMES_LOST | FaultFlag.NOISE_HIGH),
}
# In conversions: the sixth of a kind; what white noise takes to be told from load steps; a chip
# that starts anew on its beat, as after a stretched pulse, is noise from then on.
TAKES_LONGER = {"frozen": 6.5, "noise": 11.0, "stretched": 8.0}


def bench_name(case):
    return {"rail_low": "rail", "conversions_lost": "conversion_lost"}.get(case, case)


def period_s(uno):
    at_s = uno.truth("tell its conversions").conversions["time_s"]
    return at_s[-1] - at_s[-2]


def in_time_s(case, period):
    """3 conversions or 150 ms, the longer; where more conversions are needed, these."""
    return max(3 * period, 0.150, TAKES_LONGER.get(case, 0) * period) + LAG_S


class Watch:
    """What came in; every weight called stable is held to the load at once."""

    def __init__(self, uno, load_g):
        self.uno, self.load_mg = uno, load_g * 1000
        self.virtual = uno.truth("break its own wires")
        self.faults = FaultFlag(0)
        self.samples = self.stable = 0

    def wait(self, seconds):
        for one in self.uno.wait(seconds):
            self.take(one.message)

    def take(self, message):
        if isinstance(message, (Fault, Weight, Status)):
            self.faults = message.faults & SPOILS
        if isinstance(message, Sample):
            self.samples += 1
        if isinstance(message, (Sample, Weight)) and WeightFlag.STABLE in message.weight_flags:
            self.stable += 1
            assert abs(message.net_mg - self.load_mg) <= E_MG, "stable and wrong"
            assert not self.faults, "stable with a fault that spoils the weight"

    def until(self, predicate, limit_s):
        """Seconds until it holds."""
        begin_s = self.virtual.seconds
        while not predicate():
            assert self.virtual.seconds - begin_s < limit_s, f"after {limit_s} s: {self.faults!r}"
            self.wait(STEP_S)
        return self.virtual.seconds - begin_s


def weighing(uno):
    """A board with a load on it that has become stable; zero was set before."""
    uno.link.hello()
    uno.load(grams=0.0)
    watch = Watch(uno, 0.0)
    watch.until(lambda: watch.stable > 3, 12.0)
    virtual = watch.virtual
    virtual.load(grams=LOAD_G)
    uno.wait(6.0 if period_s(uno) > 0.05 else 1.5)
    watch = Watch(uno, LOAD_G)
    watch.until(lambda: watch.stable > 3, 12.0)
    return watch


def wait_for_phase(watch, share):
    """So far into the period between two conversions."""
    virtual, period = watch.virtual, period_s(watch.uno)
    next_s = virtual.conversions["time_s"][-1] + period
    watch.wait(max(next_s + share * period - virtual.seconds, STEP_S))


def check(uno, case, how, named, *, lasts_s):
    watch = weighing(uno)
    virtual = watch.virtual
    for phase in (0.03, 0.5, 0.95):
        if case == "bit_lost":  # the frame check sees it where the last bit is 0
            virtual.load(counts=2 * round(LOAD_G * virtual.counts_per_gram / 2) - 2**20)
        wait_for_phase(watch, phase)
        period = period_s(uno)
        uno.fault(bench_name(case), **how)
        watch.until(lambda: watch.faults & named, in_time_s(case, period))
        if lasts_s:
            watch.wait(lasts_s)
            assert watch.faults & named, "forgotten while it lasts"
            uno.clear_faults()
        watch.samples = watch.stable = 0
        watch.until(lambda: watch.samples and not watch.faults, RECOVERY_S + LAG_S)
        watch.stable = 0
        watch.until(lambda: watch.stable > 3, 12.0)
    status = uno.link.ask(GetInfo(), Status)
    assert named & status.faults_seen
    assert not status.faults & SPOILS
    assert status.rx_overruns == status.tx_frames_dropped == 0


LASTING_CASES = pytest.mark.parametrize("case", LASTING)
PASSING_CASES = pytest.mark.parametrize("case", [name for name in PASSING if name != "bit_lost"])


@AT_80
@LASTING_CASES
def test_a_lasting_fault_is_named_in_time_and_forgotten_in_time_at_80_sps(uno, case):
    how, named = LASTING[case]
    check(uno, case, how, named, lasts_s=0.7)


@AT_92
@LASTING_CASES
def test_a_lasting_fault_is_named_in_time_and_forgotten_in_time_at_92_sps(uno, case):
    how, named = LASTING[case]
    check(uno, case, how, named, lasts_s=0.3)


@AT_10
@LASTING_CASES
def test_a_lasting_fault_is_named_in_time_and_forgotten_in_time_at_10_sps(uno, case):
    how, named = LASTING[case]
    check(uno, case, how, named, lasts_s=1.7)


@AT_80
@PASSING_CASES
def test_a_passing_fault_is_named_in_time_and_forgotten_in_time_at_80_sps(uno, case):
    how, named = PASSING[case]
    check(uno, case, how, named, lasts_s=0.0)


@AT_10
@PASSING_CASES
def test_a_passing_fault_is_named_in_time_and_forgotten_in_time_at_10_sps(uno, case):
    how, named = PASSING[case]
    check(uno, case, how, named, lasts_s=0.0)


@AT_80
def test_a_healthy_converter_has_no_fault(uno):
    watch = weighing(uno)
    watch.wait(20.0)
    status = uno.link.ask(GetInfo(), Status)
    assert not (status.faults | status.faults_seen) & SPOILS


@AT_80
def test_each_change_of_faults_is_told_once_and_at_once(uno):
    watch = weighing(uno)
    uno.fault("cable_out")
    told = [one.message for one in uno.wait(1.5) if isinstance(one.message, Fault)]
    uno.clear_faults()
    told += [one.message for one in uno.wait(1.5) if isinstance(one.message, Fault)]
    assert [one.faults & SPOILS for one in told][-1] == FaultFlag(0)
    assert all(one.changed for one in told)
    states = [FaultFlag(0), *(one.faults for one in told)]
    for one, (before, after) in zip(told, itertools.pairwise(states), strict=True):
        assert one.changed == before ^ after
    assert watch.stable


@AT_80
@pytest.mark.parametrize("factor", [0.3, 0.8, 0.9, 0.97, 1.03, 1.1, 1.15, 1.9])
def test_a_rate_that_changes_is_named_until_it_is_learnt(uno, factor):
    watch = weighing(uno)
    rate_hz = 80 * factor
    uno.fault("rate", factor=factor)
    watch.until(lambda: FaultFlag.RATE_OUT_OF_RANGE in watch.faults, 4 / min(rate_hz, 80) + 0.04)
    watch.until(lambda: not watch.faults, RECOVERY_S)
    watch.wait(17 / rate_hz + 1.0)
    status = uno.link.ask(GetInfo(), Status)
    assert abs(status.converter_rate_hz_q16 / 65536 / rate_hz - 1) < 1e-3


@pytest.mark.board(noise_counts=38.7)
@pytest.mark.parametrize(
    ("fault", "named"),
    [("cable_out", FaultFlag.CABLE_OUT), ("dout_low", FaultFlag.DOUT_STUCK)],
)
def test_what_is_broken_from_the_start_is_named_and_mended(uno, fault, named):
    watch = Watch(uno, 0.0)
    watch.virtual.reset("power_on")
    uno.fault(fault)
    watch.until(lambda: watch.faults & named, 0.7)
    uno.clear_faults()
    watch.until(lambda: watch.samples > 3 and not watch.faults, RECOVERY_S)


@AT_80
def test_how_much_noise_is_a_fault_is_a_setting(uno):
    watch = weighing(uno)
    key = SettingKey.CHAIN_NOISE_LIMIT_COUNTS
    for limit_counts, is_fault in ((65_535, False), (400, True)):
        uno.link.ask(SetSetting(key, limit_counts), Setting, key=key)
        uno.fault("noise", counts=20_000.0)
        watch.wait(1.0)
        assert bool(watch.faults & FaultFlag.NOISE_HIGH) == is_fault
        uno.clear_faults()
        watch.wait(1.0)
