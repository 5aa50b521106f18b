# SPDX-License-Identifier: MIT
"""Recorder, tables and recordings, without a port."""

import csv
import os
import subprocess
import sys

import numpy as np
import pytest

from host.tests.captures import CaptureMaker
from host.tests.fake_chain import Chain
from terazi.errors import CannotRead, CannotWrite, FingerprintMismatch, UsageError
from terazi.link import MessageStream
from terazi.link.generated.messages import FINGERPRINT
from terazi.recorder import Capture, Recorder, load_recording


@pytest.fixture
def path(tmp_path):
    return tmp_path / "one.terazi"


def recorded(recorder, wires, *, stream=None):
    """Feed frames to a recorder as a link does."""
    stream = stream or MessageStream()
    for number, wire in enumerate(wires):
        host_s = 0.01 * number
        recorder.on_bytes(host_s, wire)
        for received in stream.feed(wire, host_s):
            recorder.add(received)
    return recorder.finish(stream, 0.01 * len(wires))


def begun(path, **more):
    recorder = Recorder(path, **more)
    recorder.begin(port="/dev/ttyACM0", baud=115200, age_s=0.0)
    return recorder


def wires_of(chain, count):
    return [chain.frame(chain.hello())] + [chain.frame(chain.sample()) for _ in range(count)]


def test_recorder_writes_capture_and_tables_that_say_the_same(path):
    import pyarrow.parquet

    chain = Chain()
    summary = recorded(begun(path), [*wires_of(chain, 200), chain.frame(chain.status())])
    assert (summary.samples, summary.frames_lost, summary.faults) == (200, 0, [])
    assert [table.name for table in summary.tables] == [
        "one.csv",
        "one.parquet",
        "one.status.csv",
    ]
    samples = load_recording(path).samples
    with open(path.with_suffix(".csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    parquet = pyarrow.parquet.read_table(path.with_suffix(".parquet")).to_pydict()
    for name in ("device_us", "conversion", "raw_counts", "fir_counts"):
        assert [int(row[name]) for row in rows] == samples[name].tolist() == parquet[name]
    assert [float(row["kf_counts"]) * 128 for row in rows] == samples["kf_counts_q7"].tolist()
    for name, column in (("weight_g", "net_mg"), ("mass_g", "mass_mg")):
        assert [float(row[name]) * 1000 for row in rows] == pytest.approx(samples[column])
        assert parquet[name] == pytest.approx(samples[column] / 1000)
    assert [int(row["restarted"]) for row in rows] == [1] + [0] * 199
    assert pyarrow.parquet.read_schema(path.with_suffix(".parquet")).metadata[b"port"]


def test_recorder_keeps_the_bytes_that_came_before_it_began(path):
    chain = Chain()
    recorder = Recorder(path)
    recorder.on_bytes(0.25, chain.frame(chain.hello()))
    recorder.begin(port="p", baud=1, age_s=0.25)
    recorder.finish(MessageStream(), 0.5)
    assert [host_s for host_s, _data in Capture(path).chunks()] == [0.25]


def test_recorder_counts_what_is_lost_and_not_what_settles(path):
    chain = Chain()
    wires = wires_of(chain, 50)
    del wires[20:23]
    wires.append(chain.frame(chain.sample(skip=2)))
    wires.append(chain.frame(chain.sample(skip=4, restart=True)))
    summary = recorded(begun(path), wires)
    assert summary.frames_lost == 3
    assert summary.conversions_lost == 3 + 2
    lost = load_recording(path).samples["lost_before"]
    assert np.flatnonzero(lost).tolist() == [19]
    assert lost[19] == 3


def test_recorder_says_what_is_missing_for_parquet(path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    summary = recorded(begun(path), wires_of(Chain(), 10))
    assert [table.name for table in summary.tables] == ["one.csv"]
    assert "pip install pyarrow" in summary.notes[0]
    assert summary.faults == []


def test_recorder_without_a_sample_leaves_tables_with_their_heads(path):
    recorded(begun(path), wires_of(Chain(), 0))
    lines = path.with_suffix(".csv").read_text().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("host_s,device_us")
    assert not path.with_suffix(".status.csv").exists()


@pytest.mark.parametrize("suffix", [".terazi", ".csv", ".parquet", ".status.csv"])
def test_recorder_refuses_where_anything_of_that_name_exists(path, suffix):
    older = path.with_suffix(suffix)
    older.write_text("precious")
    with pytest.raises(CannotWrite, match=f"{older.name} exists already"):
        Recorder(path)
    assert older.read_text() == "precious"
    assert sorted(path.parent.iterdir()) == [older]


@pytest.fixture
def unprivileged():
    """Root may write everywhere: for the test's time it is nobody."""
    if os.geteuid() != 0:
        yield
        return
    os.seteuid(65534)
    yield
    os.seteuid(0)


def test_recorder_names_a_folder_that_it_may_not_write(tmp_path, request):
    tmp_path.chmod(0o555)
    request.getfixturevalue("unprivileged")
    with pytest.raises(CannotWrite, match=r"one\.terazi: permission denied") as caught:
        Recorder(tmp_path / "one.terazi")
    assert caught.value.exit_code == 8


def test_recorder_overwrites_when_told_to(path):
    recorded(begun(path), [*wires_of(Chain(), 300), Chain().frame(Chain().status())])
    recorded(begun(path, overwrite=True), wires_of(Chain(), 3))
    assert len(load_recording(path)) == 3
    assert len(path.with_suffix(".csv").read_text().splitlines()) == 4
    assert not path.with_suffix(".status.csv").exists()


def test_recorder_does_not_take_a_tables_name_for_the_capture(tmp_path):
    with pytest.raises(UsageError, match="would be the raw capture's name") as caught:
        Recorder(tmp_path / "weights.csv")
    assert "weights.terazi" in caught.value.remedy


def test_recorder_goes_on_when_a_table_cannot_be_written(path):
    path.with_suffix(".csv").mkdir()
    recorder = Recorder(path, overwrite=True)
    recorder.begin(port="p", baud=1, age_s=0.0)
    summary = recorded(recorder, wires_of(Chain(), 100))
    assert len(load_recording(path)) == 100
    assert [table.name for table in summary.tables] == ["one.parquet"]
    assert "one.csv: is a directory" in str(summary.faults[0])


FULL_DISK = """
import resource, signal, sys
from pathlib import Path
from host.tests.fake_chain import Chain
from host.tests.recorder.test_recorder import begun, recorded, wires_of
from terazi.errors import CannotWrite
from terazi.link import MessageStream

path = Path(sys.argv[1])
recorder = begun(path)
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
chain, stream = Chain(), MessageStream()
try:
    for number, wire in enumerate(wires_of(chain, 2000)):
        recorder.on_bytes(0.01 * number, wire)
        for received in stream.feed(wire, 0.01 * number):
            recorder.add(received)
except CannotWrite as error:
    print(error)
summary = recorder.finish(stream)
print(summary.samples, [str(fault) for fault in summary.faults])
"""


def test_recorder_keeps_all_that_fitted_when_the_disk_is_full(path):
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, str(path)], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    first, last = done.stdout.splitlines()
    assert first == f"cannot write {path}: the largest allowed file size is reached"
    assert "the largest allowed file size is reached" in last
    capture = Capture(path)
    chunks = list(capture.chunks())
    assert capture.cut_off_bytes == 0
    assert not capture.ended_cleanly
    assert path.stat().st_size > 20_000 - 60
    samples = load_recording(path).samples["conversion"]
    assert samples.tolist() == list(range(1, len(chunks)))


def test_recording_of_another_protocol_names_both(path):
    maker = CaptureMaker(path)
    maker.chain.fingerprint = FINGERPRINT ^ 3
    path = maker.hello().samples(3).end()
    words = f"one.terazi.*0x{FINGERPRINT ^ 3:04X}.*0x{FINGERPRINT:04X}"
    with pytest.raises(FingerprintMismatch, match=words):
        load_recording(path)


def test_recording_of_noise_says_that_nothing_is_in_it(path):
    maker = CaptureMaker(path)
    maker.put(b"noise\0" * 50)
    with pytest.raises(CannotRead, match="holds no HELLO"):
        load_recording(maker.end())
