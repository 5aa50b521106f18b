# SPDX-License-Identifier: MIT
"""frame.c: golden vectors, round trips, and a decoder that survives any bytes."""

import fastcrc
import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.cshared import Frame, FrameDecoder, crc16, encode_frame
from terazi.cshared._cshared import ffi, lib
from terazi.models import exact
from terazi.models.vectors import golden, load

payloads = st.one_of(
    st.binary(max_size=48), st.lists(st.sampled_from([0, 0, 1, 255]), max_size=48).map(bytes)
)
u8 = st.integers(0, 255)
u32 = st.integers(0, 2**32 - 1)
frames = st.builds(Frame, u8, u8, u32, payloads)
GOOD = Frame(3, 200, 123_456, b"\0after\0")


def wire_of(frame: Frame) -> bytes:
    return encode_frame(frame.id, frame.sequence, frame.device_us, frame.payload)


def vector(name: str):
    (found,) = golden(name)
    return found


def statuses(stream: bytes) -> list[int]:
    """What the C decoder says after each byte."""
    decoder = ffi.new("frame_decoder_t *")
    lib.frame_decoder_init(decoder, lib.FRAME_BODY_MAX)
    return [lib.frame_decoder_push(decoder, byte) for byte in stream]


def test_frame_crc_has_the_published_check_value():
    table = vector("frame_published_crc")
    assert [crc16(data) for data in table["data_hex"]] == table["crc"]


def test_frame_decoder_takes_the_published_cobs_example_apart():
    table = vector("frame_published_cobs")
    for body, coded in zip(table["body_hex"], table["coded_hex"], strict=True):
        decoder = ffi.new("frame_decoder_t *")
        lib.frame_decoder_init(decoder, lib.FRAME_BODY_MAX)
        for byte in coded + b"\0":
            lib.frame_decoder_push(decoder, byte)
        assert bytes(decoder.body)[: decoder.body_len] == body
        assert exact.cobs_encode(body) == coded
        assert exact.cobs_decode(coded) == body


def test_frame_encoder_reproduces_vector_byte_for_byte():
    table = vector("frame_encode")
    rows = zip(
        table["id"], table["sequence"], table["device_us"], table["payload_hex"], strict=True
    )
    assert [encode_frame(*row) for row in rows] == table["wire_hex"]


def test_frame_decoder_reproduces_vector_status_for_status():
    table = vector("frame_decode")
    codes = {name: table.parameter(f"status_{name}") for name in ("ready", "bad_cobs", "bad_crc")}
    assert codes == {
        "ready": lib.FRAME_READY,
        "bad_cobs": lib.FRAME_BAD_COBS,
        "bad_crc": lib.FRAME_BAD_CRC,
    }
    seen = set()
    for wire, expected, body in zip(
        table["wire_hex"], table["status_hex"], table["body_hex"], strict=True
    ):
        assert statuses(wire) == list(expected)
        last = FrameDecoder().feed(wire)[-1]
        head = bytes([last.id, last.sequence]) + last.device_us.to_bytes(4, "little")
        assert head + last.payload == body
        seen |= set(expected)
    assert seen == set(range(5)), "the vector must meet every status"


@given(frame=frames)
def test_frame_survives_the_round_trip(frame):
    wire = wire_of(frame)
    assert wire.count(0) == 1
    assert wire[-1] == 0
    assert len(wire) == len(frame.payload) + 10
    assert FrameDecoder().feed(wire) == [frame]


@given(frame=frames)
def test_frame_encoder_is_its_exact_twin(frame):
    twin = exact.frame_encode(frame.id, frame.sequence, frame.device_us, frame.payload)
    assert wire_of(frame) == twin


@given(data=st.binary(max_size=255))
def test_frame_crc_is_what_fastcrc_says(data):
    assert crc16(data) == fastcrc.crc16.mcrf4xx(data) == exact.crc16_mcrf4xx(data)


# Bytes of which many are zeros and small codes, so that random streams look like frames.
noise = st.lists(st.one_of(st.sampled_from([0, 1, 2, 9, 255]), u8), max_size=200).map(bytes)


@given(stream=noise)
def test_frame_decoder_survives_any_bytes_and_judges_them_as_the_twin_does(stream):
    decoder = FrameDecoder()
    decoded = decoder.feed(stream)
    said = [status for status, _ in exact.frame_bodies(stream)]
    assert len(decoded) == said.count("ready")
    assert decoder.bad_cobs == said.count("bad_cobs")
    assert decoder.bad_len == said.count("bad_len")
    assert decoder.bad_crc == said.count("bad_crc")


@given(stream=noise, sent=st.lists(frames, max_size=3), keeps=st.integers(6, 56))
def test_frame_decoder_that_keeps_less_judges_the_same_and_writes_no_further(stream, sent, keeps):
    whole, short = ffi.new("frame_decoder_t *"), ffi.new("frame_decoder_t *")
    lib.frame_decoder_init(whole, lib.FRAME_BODY_MAX)
    lib.frame_decoder_init(short, keeps)
    ffi.buffer(short.body)[:] = b"\xa5" * lib.FRAME_BODY_MAX
    for byte in stream + b"\0" + b"".join(map(wire_of, sent)):
        assert lib.frame_decoder_push(short, byte) == lib.frame_decoder_push(whole, byte)
        assert short.body_len == whole.body_len
        kept = min(keeps, whole.body_len)
        assert bytes(short.body)[:kept] == bytes(whole.body)[:kept]
        assert bytes(short.body)[keeps:] == b"\xa5" * (lib.FRAME_BODY_MAX - keeps)


@given(stream=noise)
def test_frame_decoder_takes_up_again_after_any_bytes(stream):
    """One zero ends whatever came before; the next frame is whole."""
    decoder = FrameDecoder()
    decoder.feed(stream + b"\0")
    assert decoder.feed(wire_of(GOOD)) == [GOOD]


@given(sent=st.lists(frames, max_size=6), data=st.data())
def test_frame_decoder_does_not_care_how_the_stream_is_cut(sent, data):
    stream = b"".join(map(wire_of, sent))
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8)))
    decoder, received = FrameDecoder(), []
    for start, end in zip([0, *cuts], [*cuts, len(stream)], strict=True):
        received += decoder.feed(stream[start:end])
    assert received == sent
    assert decoder.bad_frames == 0


@given(frame=frames, data=st.data())
def test_frame_with_one_wrong_bit_is_never_taken_for_good(frame, data):
    wire = bytearray(wire_of(frame))
    bit = data.draw(st.integers(0, 8 * (len(wire) - 1) - 1))
    wire[bit // 8] ^= 1 << bit % 8
    decoder = FrameDecoder()
    received = decoder.feed(bytes(wire) + b"\0")
    assert received == []
    assert decoder.bad_frames >= 1


@given(stream=noise, rest=noise)
def test_frame_decoder_copied_in_mid_stream_goes_on_identically(stream, rest):
    decoder = FrameDecoder()
    decoder.feed(stream)
    copy = decoder.copy()
    assert decoder.feed(rest + wire_of(GOOD)) == copy.feed(rest + wire_of(GOOD))
    assert decoder.bad_frames == copy.bad_frames


def test_frame_decoder_takes_zeros_for_an_idle_line():
    decoder = FrameDecoder()
    assert decoder.feed(b"\0" * 100 + wire_of(GOOD) + b"\0" * 100 + wire_of(GOOD)) == [GOOD, GOOD]
    assert decoder.bad_frames == 0


def test_frame_encoder_refuses_what_does_not_fit():
    with pytest.raises(ValueError, match="49 bytes"):
        encode_frame(1, 0, 0, bytes(49))
    for bad in ((256, 0, 0), (0, -1, 0), (0, 0, 2**32)):
        with pytest.raises(ValueError, match="frame"):
            encode_frame(*bad, b"")
    with pytest.raises(ValueError, match="255"):
        crc16(bytes(256))


def test_every_vector_says_what_it_claims_and_where_it_comes_from():
    vectors = golden("")
    assert {each.header["kind"] for each in vectors} >= {"published", "model"}
    assert len({each.header["claim"] for each in vectors}) == len(vectors)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda text: text.replace("# kind: published", "# kind: invented"), "known kind"),
        (lambda text: text.replace("# origin", "# place"), "origin"),
        (lambda text: text.replace("data_hex,crc", "data_hex,crc16"), "columns"),
        (lambda text: text.replace("# seed: none", "# seed none"), "key: value"),
        (lambda text: "\n".join(text.splitlines()[:-1]), "columns"),
    ],
)
def test_a_vector_without_provenance_is_refused(tmp_path, spoil, message):
    source = vector("frame_published_crc")
    text = (golden.__globals__["FOLDER"] / f"{source.name}.csv").read_text()
    path = tmp_path / "frame_spoilt.csv"
    path.write_text(spoil(text))
    with pytest.raises(ValueError, match=message):
        load(path)
