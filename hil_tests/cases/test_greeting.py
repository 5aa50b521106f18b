# SPDX-License-Identifier: MIT
"""What a board says of itself: HELLO, STATUS, sequence numbers, why it started."""

import itertools

import pytest

from terazi.link.generated.messages import (
    FINGERPRINT,
    ChainOrder,
    ConverterState,
    Hello,
    KfKind,
    ResetCause,
    Status,
)


def test_hello_follows_a_start_and_names_the_chain(uno):
    hello = uno.link.hello()
    assert hello.protocol_fingerprint == FINGERPRINT
    assert (hello.version_major, hello.version_minor) >= (0, 1)
    assert (hello.gain, hello.fir_design, hello.fir_taps, hello.kf_schedule) == (128, 0, 32, 0)
    assert (hello.chain_order, hello.kf_kind) == (ChainOrder.FIR_KF, KfKind.ADAPTIVE)
    assert hello.converter_rate_hz_q16 == 0, "no rate can be known before any conversion"


def test_hello_is_the_first_frame_and_no_frame_is_missing_after_it(uno):
    uno.link.hello()
    received = uno.wait(3.0)
    first = received[0].sequence
    assert [one.sequence for one in received] == [(first + n) % 256 for n in range(len(received))]
    if uno.simulated:
        assert isinstance(received[0].message, Hello)
        assert first == 0
    assert uno.link.stream.frames_lost == 0
    assert uno.link.stream.frames_bad == 0


@pytest.mark.parametrize("cause", ["external", "power_on", "brown_out", "watchdog"])
def test_hello_names_the_reset_cause(uno, cause):
    uno.link.hello()
    uno.wait(0.3)
    uno.reset(cause)
    uno.link.stream.hello = None
    told = uno.link.hello().reset_cause
    # A boot loader may have cleared the cause before the program could read it.
    assert told in (ResetCause[cause.upper()], ResetCause.UNKNOWN)
    if uno.simulated:
        assert told == ResetCause[cause.upper()]


def test_a_main_loop_that_hangs_is_reset_by_the_watchdog_within_its_half_second(uno):
    virtual = uno.truth("have its program broken")
    uno.link.hello()
    uno.wait(0.2)
    virtual.load_flash(virtual.symbol("telemetry_tick"), b"\xff\xcf")  # rjmp to itself
    hung_s = virtual.seconds
    uno.link.stream.hello = None
    assert uno.link.hello(1.0).reset_cause == ResetCause.WATCHDOG
    assert 0.4 < virtual.seconds - hung_s < 0.7  # the watchdog's oscillator is a rough one
    assert virtual.stats["watchdog_resets"] >= 1


def test_status_comes_once_a_second_and_counts_only_what_happened(uno):
    uno.link.hello()
    statuses = [one for one in uno.wait(5.5) if isinstance(one.message, Status)]
    assert [one.message.uptime_s for one in statuses] == [1, 2, 3, 4, 5]
    for one in statuses:
        assert abs(one.device_us - 1_000_000 * one.message.uptime_s) < 50_000
    last = statuses[-1].message
    assert last.converter_state == ConverterState.RUNNING
    assert last.settling_dropped == 4
    for counter in (
        "converter_timeouts",
        "converter_bad_frames",
        "conversions_missed",
        "at_rail",
        "fir_clipped",
        "kf_clipped",
        "tx_frames_dropped",
        "rx_overruns",
        "rx_bad_frames",
    ):
        assert getattr(last, counter) == 0, counter


def test_status_tells_the_processor_load_that_the_simulator_sees(uno):
    virtual = uno.truth("tell how long it slept")
    uno.link.hello()
    uno.samples(1)
    before = virtual.stats["sleep_cycles"], virtual.cycle
    last = [one.message for one in uno.wait(4.0) if isinstance(one.message, Status)][-1]
    asleep = (virtual.stats["sleep_cycles"] - before[0]) / (virtual.cycle - before[1])
    # What is told leaves out the entries and pushes of the handlers that end a sleep.
    assert 0 <= (1.0 - asleep) - last.cpu_busy_permille / 1000.0 < 0.012


def test_status_tells_the_stack_that_was_never_touched(uno):
    virtual = uno.truth("show its memory")
    uno.link.hello()
    uno.link.status()  # the deepest call
    uno.wait(1.2)  # it is counted once a second
    start = virtual.symbol("__heap_start")
    memory = virtual.peek(start, virtual.symbol("__stack") + 1 - start)
    told = uno.link.status().stack_free_bytes
    untouched = len(memory) - len(memory.lstrip(b"\xc5"))
    assert untouched <= told <= untouched + 16, (
        "an interrupt may have come at a deeper moment since"
    )
    assert told > 180  # of 2048, what budget.toml leaves


def test_the_led_beats_once_a_second_while_all_is_well(uno):
    virtual = uno.truth("show its LED to this test")
    uno.link.hello()
    uno.wait(1.0)
    lit = []
    for _ in range(80):
        uno.wait(0.05)
        lit.append(bool(virtual.peek(0x25)[0] & 0x20))  # PORTB, PB5
    assert sum(a != b for a, b in itertools.pairwise(lit)) in (7, 8, 9)
    assert 30 <= sum(lit) <= 50
