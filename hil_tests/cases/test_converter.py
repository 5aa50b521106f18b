# SPDX-License-Identifier: MIT
"""The HX711 as the driver sees it: every sample is a conversion, and only a good one."""

import numpy as np
import pytest

from terazi.link.generated.messages import ConverterState, Sample, SampleFlag, Status


def raw_counts(received):
    return [one.message.raw_counts for one in received if isinstance(one.message, Sample)]


def states(received):
    return [one.message.converter_state for one in received if isinstance(one.message, Status)]


def good_counts(virtual):
    """What a driver may hand on: the conversions that did not settle."""
    conversions = virtual.conversions
    return set(conversions["counts"][~conversions["settling"]].tolist())


def assert_only_good_ones(received, virtual):
    """No sample but of a settled conversion. The load must never repeat a value for this."""
    assert set(raw_counts(received)) <= good_counts(virtual)


def ramp(t_s):
    """Another value at every conversion, none of them among the settling ones' wide errors."""
    return -3_000_000 + 40_000 * t_s


def restarts(samples):
    """Which of these samples primed the filters anew."""
    return [at for at, one in enumerate(samples) if SampleFlag.RESTARTED in one.flags]


def assert_protocol_kept(virtual):
    stats = virtual.stats["hx711"]
    for fault in (
        "frames_short",
        "frames_long",
        "overruns",
        "busy_pulses",
        "sck_high_too_long",
        "sck_high_too_short",
        "sck_low_too_short",
        "t1_too_short",
        "conversions_missed",
    ):
        assert stats[fault] == 0, fault


@pytest.mark.board(noise_counts=38.7)
def test_the_four_settling_conversions_are_dropped_and_no_other(uno):
    virtual = uno.truth("tell which conversions settled")
    uno.link.hello()
    told = raw_counts(uno.samples(100))
    conversions = virtual.conversions
    assert conversions["settling"].sum() == 4
    assert told == conversions["counts"][4 : 4 + len(told)].tolist()
    assert uno.link.status().settling_dropped == 4
    assert_protocol_kept(virtual)


@pytest.mark.board(noise_counts=38.7)
@pytest.mark.parametrize("counts", [0, -1, 1, 2**22, -(2**22), 2**23 - 200, 0x555555, -0x555555])
def test_every_bit_of_a_conversion_arrives(uno, counts):
    virtual = uno.truth("tell its true counts")
    uno.load(counts=counts)
    uno.link.hello()
    told = raw_counts(uno.samples(60))
    assert told == virtual.conversions["counts"][4 : 4 + len(told)].tolist()


@pytest.mark.board(noise_counts=38.7, jitter_s=0.00002, clock_ppm=150)
def test_samples_bear_the_time_at_which_their_conversion_was_done(uno):
    virtual = uno.truth("tell when its conversions were done")
    started = 0.0
    while virtual.peek(0x81)[0] == 0:  # TCCR1B: the device's clock starts when Timer1 is let run
        virtual.run_cycles(1)
        started = virtual.seconds
    uno.link.hello()
    told_s = np.array([one.device_us * 1e-6 for one in uno.samples(800)])
    true_s = virtual.conversions["time_s"][4 : 4 + len(told_s)] - started
    late_us = (told_s - true_s) * 1e6
    assert late_us.min() > -1.0, "no stamp can lie before its conversion"
    assert late_us.max() < 100.0


@pytest.mark.board(rate_sps=82.0)
def test_rate_82_is_measured(uno):
    assert_rate_is_measured(uno, 82.0)


@pytest.mark.board(rate_sps=92.0)
def test_rate_92_is_measured(uno):
    assert_rate_is_measured(uno, 92.0)


@pytest.mark.board(rate_sps=10.8)
def test_rate_10_8_is_measured(uno):
    assert_rate_is_measured(uno, 10.8)


@pytest.mark.board(rate_sps=144.0, jitter_s=0.000005)
def test_rate_of_the_fastest_clock_that_the_datasheet_allows_is_measured(uno):
    assert_rate_is_measured(uno, 144.0)


def assert_rate_is_measured(uno, rate_hz):
    uno.link.hello()
    uno.wait(22.0 / rate_hz + 0.1)  # 4 settle, 17 make 16 intervals
    early = uno.link.status().converter_rate_hz_q16 / 65536.0
    assert abs(early / rate_hz - 1.0) < 1e-3
    uno.wait(70.0 / rate_hz)
    late = uno.link.status()
    assert abs(late.converter_rate_hz_q16 / 65536.0 / rate_hz - 1.0) < 3e-4
    assert late.converter_state == ConverterState.RUNNING
    assert (late.converter_timeouts, late.conversions_missed, late.settling_dropped) == (0, 0, 4)


@pytest.mark.parametrize("fault", ["dout_high", "cable_out"])
def test_silence_is_a_time_out_and_ends_with_the_fault(uno, fault):
    virtual = uno.truth("break its own wires")
    uno.load(counts=ramp)
    uno.link.hello()
    received = uno.samples(40)
    uno.fault(fault)
    quiet = uno.wait(2.3)
    assert len(raw_counts(quiet)) <= 1
    assert states(quiet)[-1] == ConverterState.TIMED_OUT
    uno.clear_faults()
    back = uno.wait(2.3)
    assert states(back)[-1] == ConverterState.RUNNING
    samples = [one.message for one in back if isinstance(one.message, Sample)]
    assert restarts(samples) == [0, 2], "at once, and where the third good one brings trust back"
    assert_only_good_ones(received + quiet + back, virtual)
    status = uno.link.status()
    assert status.converter_timeouts >= 2
    assert status.rx_overruns == 0


def test_a_line_stuck_low_is_a_bad_frame_then_a_time_out_and_not_a_weight(uno):
    virtual = uno.truth("break its own wires")
    uno.load(counts=ramp)
    uno.link.hello()
    received = uno.samples(40)
    uno.fault("dout_low")
    received += uno.wait(2.3)
    status = uno.link.status()
    assert status.converter_state == ConverterState.TIMED_OUT
    assert status.converter_bad_frames == 1
    assert status.converter_timeouts >= 2
    assert 0 not in raw_counts(received)
    uno.clear_faults()
    received += uno.wait(1.0)
    assert uno.link.status().converter_state == ConverterState.RUNNING
    assert_only_good_ones(received, virtual)


def test_a_cable_that_is_out_from_the_start_hangs_nothing(uno):
    uno.fault("cable_out")
    uno.link.hello()
    assert not raw_counts(uno.wait(3.0))
    assert uno.link.status().converter_state == ConverterState.TIMED_OUT
    uno.clear_faults()
    assert len(raw_counts(uno.wait(1.5))) > 5


@pytest.mark.parametrize("gone_s", [0.005, 0.02, 0.05, 0.1, 0.2])
def test_a_loose_contact_lets_no_settling_sample_through(uno, gone_s):
    """The chip starts anew by itself, sooner than any time-out: only its beat tells."""
    virtual = uno.truth("break its own wires")
    uno.load(counts=ramp)
    uno.link.hello()
    received = uno.samples(40)
    for moment_s in (0.1, 0.1037, 0.1071):
        uno.fault("cable_out")
        received += uno.wait(gone_s)
        uno.clear_faults()
        received += uno.wait(moment_s + 0.3)
    assert_only_good_ones(received, virtual)
    assert len(raw_counts(received)) > 90


def test_the_shortest_break_just_behind_a_conversion_is_noticed(uno):
    virtual = uno.truth("break its own wires")
    uno.load(counts=ramp)
    uno.link.hello()
    received = uno.samples(40)
    for behind_s in (0.0003, 0.0006, 0.001, 0.0015):
        next_s = virtual.conversions["time_s"][-1] + 1 / 80
        received += uno.wait(next_s + behind_s - virtual.seconds)
        uno.fault("cable_out")
        virtual.run(0.0001)
        uno.clear_faults()
        received += uno.wait(0.5)
    assert_only_good_ones(received, virtual)
    assert uno.link.status().settling_dropped == 5 * 4


@pytest.mark.parametrize("held_ms", [5, 11, 12, 13, 25, 40, 300])
@pytest.mark.parametrize("phase", [0.0, 0.5, 0.97])
def test_a_main_loop_that_is_held_up_hands_on_no_wrong_time_and_no_wrong_count(uno, held_ms, phase):
    """A conversion read late is another one than that whose edge was seen, or a mixture of both."""
    virtual = uno.truth("have its program held up")
    uno.load(counts=ramp)
    uno.link.hello()
    received = uno.samples(40)
    next_s = virtual.conversions["time_s"][-1] + 1 / 80
    received += uno.wait(next_s + phase / 80 - virtual.seconds)
    place = virtual.symbol("telemetry_tick")
    program = virtual.flash[place : place + 2]
    virtual.load_flash(place, b"\xff\xcf")  # rjmp to itself
    virtual.run(held_ms * 1e-3)
    virtual.load_flash(place, program)
    received += uno.wait(0.4)
    assert_only_good_ones(received, virtual)
    true_s = dict(zip(virtual.conversions["counts"], virtual.conversions["time_s"], strict=True))
    samples = [one for one in received if isinstance(one.message, Sample)]
    late_s = np.array([one.device_us * 1e-6 - true_s[one.message.raw_counts] for one in samples])
    assert np.ptp(late_s) < 100e-6
    assert len(samples) > 40 + 20


@pytest.mark.board(noise_counts=0.0)
@pytest.mark.parametrize("bit", [1, 2, 12, 24, 25])
def test_a_lost_clock_pulse_is_a_bad_frame_where_the_last_bit_is_zero(uno, bit):
    virtual = uno.truth("break its own wires")
    uno.load(counts=lambda t_s: 2 * np.round(ramp(t_s) / 2))
    uno.link.hello()
    received = uno.samples(40)
    uno.fault("bit_lost", bit=bit, frames=1)
    received += uno.wait(1.0)
    status = uno.link.status()
    assert status.converter_bad_frames == 1
    assert status.converter_state == ConverterState.RUNNING
    assert status.settling_dropped == 8
    assert_only_good_ones(received, virtual)


def test_a_late_conversion_is_no_reason_to_lose_the_thread(uno):
    virtual = uno.truth("be late on command")
    uno.load(counts=ramp)
    uno.link.hello()
    received = uno.samples(40)
    for late_s in (0.003, 0.05, 0.3, 1.0):
        uno.fault("late", seconds=late_s)
        received += uno.wait(late_s + 1.0)
        assert uno.link.status().converter_state == ConverterState.RUNNING
    assert_only_good_ones(received, virtual)
    assert_protocol_kept(virtual)


@pytest.mark.board(noise_counts=38.7)
def test_a_noisy_line_is_survived(uno):
    """Bits that flip within a frame cannot be told from good ones: it has no check on them."""
    uno.link.hello()
    uno.samples(40)
    uno.fault("noisy_line", probability=0.02)
    assert len(raw_counts(uno.wait(5.0))) >= 398
    uno.clear_faults()
    uno.wait(1.0)
    assert len(raw_counts(uno.wait(1.0))) >= 78
    assert uno.link.status().converter_state == ConverterState.RUNNING


@pytest.mark.parametrize(("side", "rail"), [("high", 2**23 - 1), ("low", -(2**23))])
def test_the_rails_are_flagged_and_counted(uno, side, rail):
    uno.link.hello()
    uno.samples(20)
    before = uno.link.status().at_rail
    uno.fault("rail", side=side)
    received = uno.wait(1.0)
    at_rail = [one.message for one in received if rail in raw_counts([one])]
    assert len(at_rail) >= 78
    assert all(SampleFlag.AT_RAIL in one.flags for one in at_rail)
    assert before == 0
    assert uno.link.status().at_rail >= len(at_rail)


@pytest.mark.board(update_pulse_s=0.0001)
def test_a_lost_conversion_is_counted_flagged_and_no_reason_for_trust(uno):
    """DOUT is held high over one conversion, and let go just before the next falls."""
    virtual = uno.truth("break its own wires")
    uno.load(counts=ramp)
    uno.link.hello()
    uno.samples(40)
    period_s = 1 / 80
    edge_s = virtual.conversions["time_s"][-1]
    uno.wait(edge_s + 0.6 * period_s - virtual.seconds)
    uno.fault("dout_high")
    uno.wait(edge_s + 2 * period_s - 0.00005 - virtual.seconds)
    uno.clear_faults()
    later = uno.samples(20)
    flags = [one.message.flags for one in later]
    assert flags[0] == SampleFlag.RESTARTED | SampleFlag.GAP
    assert restarts([one.message for one in later]) == [0, 2]
    assert [one for one in flags[1:] if SampleFlag.GAP in one] == []
    status = uno.link.status()
    assert (status.conversions_missed, status.settling_dropped) == (1, 8)
    truth = virtual.conversions["counts"]
    assert [truth[one.message.conversion - 1] for one in later] == raw_counts(later)


@pytest.mark.board(noise_counts=38.7)
def test_a_rate_that_changes_is_measured_anew(uno):
    """As when somebody moves the RATE jumper: every conversion is late, 66.67 instead of 80 SPS."""
    virtual = uno.truth("change its clock")
    uno.link.hello()
    uno.samples(80)
    uno.wait(virtual.conversions["time_s"][-1] + 0.001 - virtual.seconds)
    received = []
    for _ in range(80):
        uno.fault("late", seconds=0.0025)
        received += uno.wait(0.015)
    status = uno.link.status()
    assert abs(status.converter_rate_hz_q16 / 65536 * 0.015 - 1) < 1e-3
    assert status.converter_state == ConverterState.RUNNING
    assert len(raw_counts(received)) > 50, "16 conversions to learn it, 4 to settle, no more"
    uno.wait(1.0)
    assert abs(uno.link.status().converter_rate_hz_q16 / 65536 / 80 - 1) < 1e-3
    assert_only_good_ones(uno.wait(0.5), virtual)
