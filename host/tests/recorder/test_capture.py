# SPDX-License-Identifier: MIT
"""The capture file: what goes in comes out, whatever cuts it off."""

import errno
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from terazi.errors import CannotRead, CannotWrite
from terazi.recorder import Capture, CaptureWriter
from terazi.recorder.capture import RECORD_HEAD

CHUNKS = [(0.5, b"first"), (0.75, b"\0\xff" * 40), (1.25, b"last")]
METADATA = {"product": "terazi", "port": "/dev/ttyÄ"}


@pytest.fixture
def path(tmp_path):
    return tmp_path / "one.terazi"


def written(path, chunks=CHUNKS, *, end_s=2.0):
    writer = CaptureWriter(path)
    writer.begin(METADATA)
    for host_s, data in chunks:
        writer.append(host_s, data)
    if end_s is None:
        writer.abandon()
    else:
        writer.close(end_s)
    return path


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.floats(0, 1e9), st.binary(min_size=1, max_size=300)), max_size=8))
def test_capture_gives_back_every_byte_with_its_time(tmp_path, chunks):
    path = tmp_path / "some.terazi"
    path.unlink(missing_ok=True)
    capture = Capture(written(path, chunks))
    assert capture.metadata == METADATA
    assert list(capture.chunks()) == chunks
    assert (capture.ended_cleanly, capture.cut_off_bytes, capture.duration_s) == (True, 0, 2.0)


def test_capture_is_on_disk_record_by_record(path):
    writer = CaptureWriter(path)
    writer.begin(METADATA)
    for count, (host_s, data) in enumerate(CHUNKS, start=1):
        writer.append(host_s, data)
        assert list(Capture(path).chunks()) == CHUNKS[:count]
    writer.abandon()


def test_capture_cut_anywhere_keeps_its_whole_records(path):
    whole = written(path).read_bytes()
    first = whole.index(RECORD_HEAD.pack(*[CHUNKS[0][0], len(CHUNKS[0][1])]))
    ends = [first]
    for _host_s, data in CHUNKS:
        ends.append(ends[-1] + RECORD_HEAD.size + len(data))
    for size in range(first, len(whole)):
        path.write_bytes(whole[:size])
        capture = Capture(path)
        kept = sum(end <= size for end in ends) - 1
        assert list(capture.chunks()) == CHUNKS[:kept]
        assert not capture.ended_cleanly
        assert capture.cut_off_bytes == size - ends[kept]


def test_capture_stops_at_a_record_of_absurd_length(path):
    written(path, end_s=None)
    with open(path, "ab") as file:
        file.write(RECORD_HEAD.pack(3.0, 0xFFFFFFFF) + b"damage")
    capture = Capture(path)
    assert list(capture.chunks()) == CHUNKS
    assert capture.cut_off_bytes == RECORD_HEAD.size + 6


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b"host_s,device_us\n0,1\n", "not a Terazi capture"),
        (os.urandom(4096), "not a Terazi capture"),
        (b"TERAZI-CAPTURE 99\n{}\n", "format 99"),
        (b'TERAZI-CAPTURE 1\n{"product": "ter', "cut off within its header"),
        (b"TERAZI-CAPTURE 1\nnonsense\n", "damaged header"),
        (b"TERAZI-CAPTURE 1\n[1]\n", "damaged header"),
    ],
    ids=["empty", "csv", "noise", "newer", "cut header", "bad json", "no object"],
)
def test_capture_says_why_a_file_is_none(path, content, words):
    path.write_bytes(content)
    with pytest.raises(CannotRead, match=words) as caught:
        Capture(path)
    assert caught.value.exit_code == 9


def test_capture_names_a_file_that_is_missing_or_a_folder(tmp_path):
    with pytest.raises(CannotRead, match="there is no file"):
        Capture(tmp_path / "nothing.terazi")
    with pytest.raises(CannotRead, match="is a directory"):
        Capture(tmp_path)


def test_writer_refuses_an_existing_file_and_leaves_it_alone(path):
    path.write_bytes(b"precious")
    with pytest.raises(CannotWrite, match="exists already") as caught:
        CaptureWriter(path)
    assert caught.value.exit_code == 8
    assert "--force" in caught.value.remedy
    assert path.read_bytes() == b"precious"


def test_writer_leaves_an_old_file_alone_until_it_begins(path):
    path.write_bytes(b"precious" * 100)
    CaptureWriter(path, overwrite=True).abandon()
    assert path.read_bytes() == b"precious" * 100
    writer = CaptureWriter(path, overwrite=True)
    writer.begin(METADATA)
    writer.close(0.0)
    assert list(Capture(path).chunks()) == []


def test_writer_that_never_began_leaves_no_trace(path):
    CaptureWriter(path).abandon()
    assert not path.exists()


def test_writer_that_could_not_even_begin_leaves_no_trace(path, monkeypatch):
    def full(_file, _data):
        raise OSError(errno.ENOSPC, "No space left on device")

    writer = CaptureWriter(path)
    monkeypatch.setattr(os, "write", full)
    with pytest.raises(CannotWrite, match="the disk is full"):
        writer.begin(METADATA)
    writer.abandon()
    assert not path.exists()


def test_writer_names_a_missing_folder(tmp_path):
    with pytest.raises(CannotWrite, match="there is no folder"):
        CaptureWriter(tmp_path / "no" / "one.terazi")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full on this system")
def test_writer_names_a_full_disk():
    writer = CaptureWriter(Path("/dev/full"), overwrite=True)
    with pytest.raises(CannotWrite, match="the disk is full"):
        writer.begin(METADATA)
    writer.abandon()
