# SPDX-License-Identifier: MIT
"""Commands by frame: done, answered, or refused by name and then without effect."""

import random

import pytest

from boards import RawCommand
from terazi.cshared import encode_frame
from terazi.link.generated.messages import (
    Ack,
    GetInfo,
    GetPoint,
    GetSetting,
    Hello,
    Point,
    Result,
    Sample,
    SaveSettings,
    SetStream,
    Setting,
    Show,
    Status,
    Step,
    StreamFlag,
    Tare,
    TareClear,
    View,
    Weight,
    WeightFlag,
)


def kinds(received):
    return {type(one.message) for one in received}


def test_get_info_is_answered_by_ack_hello_and_status_in_this_order(uno):
    uno.link.hello()
    uno.link.command(SetStream(mask=0))
    uno.wait(0.1)
    uno.link.send(GetInfo())
    answered = [type(one.message) for one in uno.wait(0.3)]
    assert answered == [Ack, Hello, Status]


@pytest.mark.parametrize("mask", [StreamFlag(n) for n in range(16)], ids=str)
def test_the_stream_mask_chooses_what_comes_unasked(uno, mask):
    uno.link.hello()
    uno.link.command(SetStream(mask=mask))
    uno.wait(2.0)
    wanted = {
        kind
        for flag, kind in (
            (StreamFlag.SAMPLE, Sample),
            (StreamFlag.STATUS, Status),
            (StreamFlag.WEIGHT, Weight),
            (StreamFlag.EVENT, Step),
        )
        if flag in mask
    }
    uno.load(grams=300.0)
    assert kinds(uno.wait(2.6)) == wanted


def test_every_ack_bears_the_sequence_of_its_command(uno):
    uno.link.hello()
    uno.link.command(SetStream(mask=0))
    uno.wait(0.1)
    sent = [uno.link.send(RawCommand(0x60 + n)) for n in range(5)]
    acks = [one.message for one in uno.wait(0.5)]
    assert [ack.command_sequence for ack in acks] == sent
    assert [ack.command for ack in acks] == [0x60 + n for n in range(5)]


def test_a_tare_before_the_weight_is_stable_is_refused(uno):
    uno.truth("be asked surely before its first conversion has settled")
    uno.link.hello()
    assert uno.link.request(Tare()).result == Result.NOT_STABLE


def test_a_tare_of_a_load_makes_it_weigh_nothing(uno):
    uno.link.hello()
    uno.samples(200)
    uno.load(grams=1500.0)
    uno.samples(400)
    uno.link.command(Tare())
    uno.wait(0.1)
    uno.load(grams=1750.0)
    last = uno.samples(400)[-1].message
    assert abs(last.net_mg - 250_000) < 50
    assert last.weight_flags & (WeightFlag.TARED | WeightFlag.ZEROED | WeightFlag.STABLE) == 0x61


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_garbage_on_the_line_is_counted_and_survived(uno, seed):
    uno.link.hello()
    uno.wait(0.5)
    before = uno.link.status()
    noise = random.Random(seed).randbytes(2000)
    uno.write(noise)
    uno.wait(0.5)
    after = uno.link.status()
    assert after.rx_bad_frames > before.rx_bad_frames
    assert after.uptime_s >= before.uptime_s, "it must not have restarted"
    assert uno.link.stream.frames_lost == 0
    assert uno.link.stream.frames_bad == 0
    uno.samples(10)


def test_a_torn_frame_costs_only_itself(uno):
    uno.link.hello()
    uno.link.command(SetStream(mask=0))
    before = uno.link.status().rx_bad_frames
    whole = encode_frame(GetInfo.ID, 77, 0, b"")
    uno.write(b"\0" + whole[:5] + b"\0" + whole)
    answers = [one.message for one in uno.wait(0.3)]
    assert [ack.command_sequence for ack in answers if isinstance(ack, Ack)][-1] == 77
    assert uno.link.status().rx_bad_frames == before + 1


def test_a_frame_with_one_bit_wrong_is_not_obeyed(uno):
    uno.link.hello()
    uno.link.command(SetStream(mask=3))
    good = bytearray(encode_frame(SetStream.ID, 5, 0, b"\0"))
    for place in range(len(good) - 1):
        for bit in range(8):
            bad = bytearray(good)
            bad[place] ^= 1 << bit
            uno.write(b"\0" + bytes(bad) + b"\0")
    uno.wait(3.0)
    assert kinds(uno.wait(1.3)) == {Sample, Status}


@pytest.mark.board(noise_counts=38.7, rate_sps=92.0)
def test_commands_at_full_stream_cost_not_one_frame_nor_sample(uno):
    uno.link.hello()
    uno.link.command(SetStream(mask=15))
    uno.wait(0.5)
    samples, conversion = 0, None
    for round_ in range(40):
        uno.link.ask(GetSetting(round_), Setting, key=round_)
        uno.link.ask(GetPoint(round_ % 2), Point, index=round_ % 2)
        uno.link.command((SaveSettings(), Show(View.LIVE), GetInfo(), TareClear())[round_ % 4])
        uno.load(grams=200.0 * (round_ // 8 % 2))
        for one in uno.wait(0.2):
            if isinstance(one.message, Sample):
                assert conversion is None or one.message.conversion == conversion + 1
                conversion, samples = one.message.conversion, samples + 1
    assert samples > 700
    status = uno.link.status()
    assert status.tx_frames_dropped == status.rx_overruns == status.rx_bad_frames == 0
    assert status.conversions_missed == 0
    assert uno.link.stream.frames_lost == uno.link.stream.frames_bad == 0
