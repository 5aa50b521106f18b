# SPDX-License-Identifier: MIT
"""Both directions of the line full, and for long: nothing torn, nothing lost unsaid."""

import itertools

import pytest

from terazi.cshared import encode_frame
from terazi.link.generated.messages import (
    Ack,
    ConverterState,
    GetInfo,
    Hello,
    Sample,
    SetStream,
    SetTextMode,
    Status,
)

HX711_COARSE_SHIFT = 10  # of firmware/drivers/hx711.c
OWN_SECOND_US = 12  # where telemetry.c keeps its two times, behind the head of STATUS
CHIP_WAITING_SINCE = 14  # where hx711.c keeps it, behind its counters and two times
LINE_BYTES_S = 11_520  # 115200 baud, 10 bits each


def flood(command_id, payload, seconds):
    """Frames of one command that keep the line to the device full for so long."""
    frames, sequence, size = [], 0, 0
    while size < seconds * LINE_BYTES_S:
        frames.append(encode_frame(command_id, sequence % 256, 0, payload))
        size += len(frames[-1])
        sequence += 1
    return frames


def assert_no_sample_missing(received):
    """What is streamed goes before answers, however many are asked for."""
    numbers = [one.message.conversion for one in received if isinstance(one.message, Sample)]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert len(numbers) > 100


@pytest.mark.board(noise_counts=38.7)
def test_both_directions_saturated_tear_no_frame_and_account_for_every_one(uno):
    uno.link.hello()
    uno.wait(0.5)
    frames = flood(GetInfo.ID, b"", 4.0)
    uno.write(b"".join(frames))
    received = uno.wait(5.0)
    status = uno.link.status()
    assert status.rx_overruns == 0
    assert status.rx_bad_frames == 0
    assert uno.link.stream.frames_bad == 0
    assert status.tx_frames_dropped > 0, "the answers are four times as long as the questions"
    assert uno.link.stream.frames_lost == status.tx_frames_dropped
    kinds = [type(one.message) for one in received]
    assert kinds.count(Ack) + kinds.count(Hello) > len(frames) / 8
    assert_no_sample_missing(received)


@pytest.mark.board(noise_counts=38.7, clock_ppm=-4321)
def test_no_spike_of_trailing_ones_under_heavy_traffic(uno):
    """What stretches PD_SCK in other libraries is here: an interrupt for every byte both ways."""
    virtual = uno.truth("tell its true counts")
    uno.load(counts=-5_000_000)
    uno.link.hello()
    uno.samples(1)
    uno.write(b"".join(flood(SetStream.ID, b"\1", 20.0)))
    received = [one for one in uno.wait(21.0) if isinstance(one.message, Sample)]
    truth = virtual.conversions["counts"]
    assert_no_sample_missing(received)
    assert len(received) > 1600
    for one in received:
        assert one.message.raw_counts == truth[one.message.conversion - 1]
    stats = virtual.stats["hx711"]
    assert stats["sck_high_max_ticks"] <= 10
    assert stats["frames_short"] + stats["frames_long"] + stats["overruns"] == 0


@pytest.mark.board(noise_counts=38.7)
def test_text_mode_under_a_full_line_loses_whole_lines_only(uno):
    uno.link.hello()
    uno.samples(1)
    uno.link.command(SetTextMode(on=1))
    uno.read_raw(0.2)
    uno.write(b"info\r\n" * 500)
    text = uno.read_raw(2.0).rsplit(b"\0", 1)[-1].decode("ascii")
    lines = text.split("\r\n")[1:-1]
    assert len(lines) > 200
    starts = ("raw:", "# Terazi v", "# gain=")
    assert all(line.startswith(starts) for line in lines)
    assert all(line.count(":") == 5 for line in lines if line.startswith("raw:"))


@pytest.mark.board(noise_counts=38.7)
def test_a_wrong_baud_rate_is_counted_and_survived(uno):
    virtual = uno.truth("have its line set to another speed by this test")
    uno.link.hello()
    uno.wait(0.2)
    virtual.uart.host_baud = 57_600
    uno.write(bytes(range(256)))
    uno.read_raw(0.3)
    virtual.uart.host_baud = 115_200
    uno.read_raw(0.1)
    lost = uno.link.stream.frames_lost
    status = uno.link.status()
    assert status.rx_overruns > 0
    assert status.converter_state == ConverterState.RUNNING
    assert len(uno.samples(20)) == 20
    assert uno.link.stream.frames_lost - lost < 40, "only what the test did not hear is missing"


@pytest.mark.board(noise_counts=38.7)
def test_the_device_clock_wraps_without_a_stir(uno):
    """After 71.6 minutes; here all that remembers a time is set 2 s before that."""
    virtual = uno.truth("have its clock set")
    before_wrap_us = 2**32 - 62 * 32768
    coarse = before_wrap_us >> HX711_COARSE_SHIFT & 0xFFFF
    uno.link.hello()
    wrap = before_wrap_us.to_bytes(4, "little")
    virtual.poke(virtual.symbol("overflow_us"), wrap)
    virtual.poke(virtual.symbol("own") + OWN_SECOND_US, wrap + wrap)  # and closed_us
    virtual.poke(virtual.symbol("chip") + CHIP_WAITING_SINCE, coarse.to_bytes(2, "little"))
    received = uno.samples(320)
    stamps_us = [one.device_us for one in received]
    assert stamps_us[0] % 2**32 > 2**31 > stamps_us[-1] % 2**32
    steps_us = {late - early for early, late in itertools.pairwise(stamps_us)}
    assert steps_us <= set(range(12_480, 12_521))
    status = uno.link.status()
    assert (status.settling_dropped, status.converter_timeouts, status.uptime_s) == (4, 0, 4)


@pytest.mark.board(noise_counts=38.7, clock_ppm=137)
def test_ten_minutes_at_80_sps_without_a_lost_or_corrupt_frame(uno):
    virtual = uno.truth("let ten minutes go by in seconds")
    uno.link.hello()
    samples = statuses = 0
    conversion = None
    while virtual.seconds < 600.0:
        for one in uno.wait(1.0):
            statuses += isinstance(one.message, Status)
            if isinstance(one.message, Sample):
                samples += 1
                follows = conversion is None or one.message.conversion == conversion % 65536 + 1
                assert follows, "a conversion is missing"
                conversion = one.message.conversion
    stream = uno.link.stream
    assert (stream.frames_lost, stream.frames_bad, stream.frames_unknown) == (0, 0, 0)
    assert len(virtual.conversions) - 4 - samples in (0, 1), "the last may still be on its way"
    assert statuses in (599, 600)
    status = uno.link.status()
    assert status.settling_dropped == 4
    assert status.conversions - 4 - samples in (0, 1, 2)
    assert status.tx_frames_dropped == status.rx_overruns == status.conversions_missed == 0
    assert abs(status.converter_rate_hz_q16 / 65536 / (80 * (1 + 137e-6)) - 1) < 3e-4
    assert virtual.stats["tx_overwrites"] == virtual.stats["rx_overruns"] == 0
