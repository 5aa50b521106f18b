# SPDX-License-Identifier: MIT
"""From bytes to messages."""

import dataclasses
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.tests.fake_chain import Chain
from terazi.cshared import encode_frame
from terazi.errors import FingerprintMismatch
from terazi.link import MessageStream
from terazi.link.generated.messages import FINGERPRINT, GetInfo, Hello, Sample, Status
from terazi.link.stream import CLOCK_PERIOD_US


@pytest.fixture
def chain():
    return Chain()


def fed(*pieces: bytes, stream: MessageStream | None = None, host_s: float = 0.0):
    stream = stream or MessageStream()
    return stream, [one for piece in pieces for one in stream.feed(piece, host_s)]


def test_stream_gives_messages_in_order_with_their_time(chain):
    wire = [chain.frame(chain.hello()), chain.frame(chain.sample()), chain.frame(chain.status())]
    stream, received = fed(b"".join(wire), host_s=1.25)
    assert [type(one.message) for one in received] == [Hello, Sample, Status]
    assert [one.sequence for one in received] == [0, 1, 2]
    assert all(one.host_s == 1.25 for one in received)
    assert received[1].device_us == chain.device_us
    assert (stream.frames, stream.frames_lost, stream.frames_bad) == (3, 0, 0)
    assert stream.hello == chain.hello()


@given(cuts=st.lists(st.integers(0, 200), max_size=12))
def test_stream_does_not_care_how_the_bytes_are_cut(cuts):
    chain = Chain()
    wire = chain.frame(chain.hello()) + b"".join(chain.frame(chain.sample()) for _ in range(5))
    edges = [0, *sorted(min(cut, len(wire)) for cut in cuts), len(wire)]
    pieces = [wire[a:b] for a, b in pairwise(edges)]
    assert fed(*pieces)[1] == fed(wire)[1]


def test_stream_counts_frames_lost_by_sequence_and_says_where(chain):
    wire = [chain.frame(chain.sample()) for _ in range(300)]
    del wire[200:203], wire[10]
    stream, received = fed(*wire)
    assert stream.frames_lost == 4
    assert {at: one.lost_before for at, one in enumerate(received) if one.lost_before} == {
        10: 1,
        199: 3,
    }


def test_stream_counts_a_corrupt_frame_as_bad_and_as_lost(chain):
    wire = [bytearray(chain.frame(chain.sample())) for _ in range(10)]
    wire[4][9] ^= 0x10
    stream, received = fed(*map(bytes, wire))
    assert len(received) == 9
    assert (stream.frames_bad, stream.frames_lost) == (1, 1)


def test_stream_does_not_count_the_torn_frame_at_its_beginning(chain):
    wire = chain.frame(chain.sample())[7:] + chain.frame(chain.sample())
    stream, received = fed(wire)
    assert len(received) == 1
    assert (stream.frames_bad, stream.frames_lost) == (0, 0)


@given(noise=st.binary(max_size=400))
def test_stream_survives_any_noise_and_takes_up_again(noise):
    chain = Chain()
    stream, received = fed(noise, b"\0", chain.frame(chain.hello()), chain.frame(chain.sample()))
    assert received[-1].message.raw_counts == chain.load(1 / 82.0)
    assert stream.bytes_in > len(noise)


def test_stream_undoes_the_wrap_of_the_devices_clock(chain):
    stream = MessageStream()
    seen = []
    for step in range(6):
        us = CLOCK_PERIOD_US - 30_000 + 12_000 * step
        seen += stream.feed(chain.frame(chain.sample(), us), 100 + 0.012 * step)
    assert [one.device_us for one in seen] == [
        CLOCK_PERIOD_US - 30_000 + 12_000 * step for step in range(6)
    ]


def test_stream_bridges_a_silence_of_hours_by_the_hosts_clock(chain):
    stream = MessageStream()
    (before,) = stream.feed(chain.frame(chain.sample(), 5_000_000), 0.0)
    silence_s = 3 * 3600
    us = 5_000_000 + silence_s * 1_000_000
    (after,) = stream.feed(chain.frame(chain.sample(), us), silence_s + 20.0)
    assert after.device_us - before.device_us == silence_s * 1_000_000


def test_stream_lets_a_sample_be_older_than_the_status_before_it(chain):
    _stream, received = fed(
        chain.frame(chain.status(), 1_000_400), chain.frame(chain.sample(), 1_000_000)
    )
    assert [one.device_us for one in received] == [1_000_400, 1_000_000]


def test_stream_sees_a_restart_of_the_device_and_loses_nothing_by_it(chain):
    chain.device_us = 40 * 60 * 1_000_000  # more than half a period of its clock
    late = [chain.frame(chain.status(), chain.device_us) for _ in range(7)]
    anew = Chain()
    stream, received = fed(*late, anew.frame(anew.hello(), 900), anew.frame(anew.sample()))
    assert [one.boot for one in received] == [0] * 7 + [1, 1]
    assert received[-2].device_us == 900
    assert stream.frames_lost == 0


def test_stream_takes_a_hello_that_was_asked_for_as_the_same_run(chain):
    chain.device_us = 70_000_000
    wire = [chain.frame(chain.status()), chain.frame(chain.hello(), 70_300_000)]
    assert [one.boot for one in fed(*wire)[1]] == [0, 0]


def test_stream_refuses_another_fingerprint_and_names_both(chain):
    hello = dataclasses.replace(chain.hello(), protocol_fingerprint=FINGERPRINT ^ 0x0F0F)
    with pytest.raises(FingerprintMismatch) as caught:
        fed(chain.frame(hello))
    assert f"0x{FINGERPRINT:04X}" in str(caught.value)
    assert f"0x{FINGERPRINT ^ 0x0F0F:04X}" in str(caught.value)
    assert caught.value.exit_code == 7


def test_stream_names_the_fingerprint_of_a_hello_whose_layout_it_does_not_know():
    head = bytes([0x34, 0x12, 9, 8, 7, 0, 0, 0, 0])
    with pytest.raises(FingerprintMismatch, match=r"9\.8\.7.*0x1234"):
        fed(encode_frame(Hello.ID, 0, 0, head + b"from the future"))


@pytest.mark.parametrize(
    "frame",
    [
        encode_frame(0x7F, 1, 0, b""),
        encode_frame(Sample.ID, 1, 0, b"short"),
        encode_frame(Hello.ID, 1, 0, b"x"),
        encode_frame(GetInfo.ID, 1, 0, b""),
    ],
    ids=["unknown id", "wrong length", "hello too short", "a command from the device"],
)
def test_stream_counts_good_frames_that_say_nothing(chain, frame):
    stream, received = fed(chain.frame(chain.hello()), frame)
    assert len(received) == 1
    assert (stream.frames_unknown, stream.frames_bad, stream.frames_lost) == (1, 0, 0)
