# SPDX-License-Identifier: MIT
"""What an IMU told: as columns in memory, as tables on disk, and only where there is one."""

import csv

import numpy as np
import pytest

from host.tests.captures import CaptureMaker
from host.tests.fake_imu import TURN_DEG_S, FakeImu
from terazi.errors import CannotRead, CannotWrite
from terazi.link import MessageStream
from terazi.link.generated.messages import Hello, ImuStatus
from terazi.recorder import Recorder, load_recording
from terazi.recorder.capture import Capture
from terazi.recorder.inertial import counts_of, quats_of

EVERY = 5


@pytest.fixture
def path(tmp_path):
    return tmp_path / "one.terazi"


@pytest.fixture
def capture(path):
    """3.2 s at 500 Hz, on the way into the turn; a field in every tenth sample."""
    maker = CaptureMaker(path).hello().samples(20)
    return maker.imu(FakeImu(every=EVERY, mag_every=10), 1600).end()


def recorded_again(capture, path):
    """The same bytes through a recorder, which makes the tables."""
    recorder, stream = Recorder(path), MessageStream()
    recorder.begin(port="/dev/ttyACM0", baud=500_000, age_s=0.0)
    for host_s, data in Capture(capture).chunks():
        recorder.on_bytes(host_s, data)
        for received in stream.feed(data, host_s):
            recorder.add(received)
    return recorder.finish(stream, 4.0)


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_recording_keeps_each_kind_as_columns(capture):
    recording = load_recording(capture)
    inertial = recording.inertial
    samples = np.arange(EVERY, 1601, EVERY)
    assert inertial.attitude["sample"].tolist() == samples.tolist()
    assert inertial.imu["sample"].tolist() == samples.tolist()
    assert inertial.mag["sample"].tolist() == list(range(10, 1601, 10))
    assert inertial.attitude["device_us"].tolist() == (samples * 2000).tolist()
    assert counts_of(inertial.imu, "acc_")[0, 2] == pytest.approx(2048, abs=15)
    assert np.linalg.norm(quats_of(inertial.attitude), axis=1) == pytest.approx(1.0, abs=1e-3)
    assert [type(one.message) for _at, one in recording.others][-1] is ImuStatus
    assert len(recording) == 20


def test_recording_knows_what_was_told_before_which_sample(capture):
    inertial = load_recording(capture).inertial
    kinds = {type(one.message): order for order, one in inertial.told}
    assert kinds[Hello] < inertial.imu["order"][0] < kinds[ImuStatus]
    orders = np.concatenate([inertial.imu["order"], inertial.attitude["order"]])
    assert len(set(orders.tolist())) == len(orders)
    assert (inertial.imu["order"] < inertial.attitude["order"]).all()


def test_tables_of_an_imu_are_in_units_and_say_what_the_capture_says(capture, tmp_path):
    import pyarrow.parquet

    again = tmp_path / "again.terazi"
    summary = recorded_again(capture, again)
    assert summary.faults == []
    assert {table.name.removeprefix("again.") for table in summary.tables} == {
        *("csv", "parquet", "attitude.csv", "attitude.parquet", "imu.csv", "imu.parquet"),
        *("mag.csv", "mag.parquet", "imu_status.csv"),
    }
    inertial = load_recording(again).inertial
    attitude = rows_of(again.with_suffix(".attitude.csv"))
    assert list(attitude[0])[:8] == [
        *("host_s", "device_s", "boot", "sample", "quat_w", "quat_x", "quat_y", "quat_z")
    ]
    assert [float(row["quat_x"]) for row in attitude] == pytest.approx(
        quats_of(inertial.attitude)[:, 1], abs=1e-10
    )
    assert float(attitude[-1]["roll_deg"]) == pytest.approx(TURN_DEG_S * 0.2, abs=1.0)
    assert {row["rest"] for row in attitude} == {"0", "1"}
    assert float(attitude[-1]["device_s"]) == 3.2
    imu = rows_of(again.with_suffix(".imu.csv"))
    assert float(imu[0]["acc_z_m_s2"]) == pytest.approx(9.80665, abs=0.1)
    assert float(imu[-1]["gyro_x_deg_s"]) == pytest.approx(TURN_DEG_S, abs=3.0)
    assert [int(row["acc_z_counts"]) for row in imu] == inertial.imu["acc_z_counts"].tolist()
    assert {row["temperature_deg_c"] for row in imu} == {"4.177"}
    assert [row["z_counts"] for row in rows_of(again.with_suffix(".mag.csv"))] == ["-2400"] * 160
    status = rows_of(again.with_suffix(".imu_status.csv"))
    assert [(row["state"], row["identity"], row["mag_kind"]) for row in status] == (
        [("running", "104", "qmc5883l")] * 3
    )
    assert float(status[-1]["bias_x_deg_s"]) == pytest.approx(25 / 16.384, abs=0.1)
    for kind in ("attitude", "imu", "mag"):
        parquet = pyarrow.parquet.read_table(again.with_suffix(f".{kind}.parquet"))
        assert parquet.column_names == list(rows_of(again.with_suffix(f".{kind}.csv"))[0])
        assert parquet["sample"].to_pylist() == getattr(inertial, kind)["sample"].tolist()


def test_no_table_of_an_imu_where_there_is_none(path, tmp_path):
    capture = CaptureMaker(path).hello().samples(20).end()
    again = tmp_path / "again.terazi"
    older = again.with_suffix(".imu.parquet")
    older.write_text("of an older recording")
    with pytest.raises(CannotWrite, match=r"again\.imu\.parquet exists already"):
        Recorder(again)
    older.unlink()
    summary = recorded_again(capture, again)
    assert [table.name for table in summary.tables] == ["again.csv", "again.parquet"]
    assert not list(tmp_path.glob("again.*imu*"))


def test_recording_of_a_board_without_a_scale_is_read_where_its_imu_will_do(path):
    CaptureMaker(path).hello().imu(FakeImu(), 50).end()
    with pytest.raises(CannotRead, match="holds no samples") as refused:
        load_recording(path)
    assert "terazi attitude FILE" in refused.value.remedy
    assert len(load_recording(path, needs_samples=False).inertial.imu["sample"]) == 10


def test_recording_without_anything_measured_is_refused(path):
    CaptureMaker(path).hello().end()
    with pytest.raises(CannotRead, match="holds no samples"):
        load_recording(path, needs_samples=False)
