# SPDX-License-Identifier: MIT
"""A capture is a walk: its samples calibrated, in SI, on the device's clock; with what the device
said of zero velocity. What spoils it is told, with what to do."""

import json
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from typer.testing import CliRunner

from host.tests.captures import CaptureMaker
from host.tests.fake_imu import FakeImu
from terazi import units
from terazi.applications.walks import Options, estimate, find_walks, load_walk, simulator
from terazi.applications.walks.score import path_errors
from terazi.cli import app
from terazi.cshared import ImuCal
from terazi.errors import CannotRead, FingerprintMismatch, UsageError
from terazi.link.generated.messages import Attitude, Imu
from terazi.link.generated.settings import SETTINGS_BY_NAME
from terazi.link.stream import MessageStream
from terazi.recorder import Capture
from terazi.recorder.tables import Tables, table_paths

RATE_HZ = 500
PIECES = [*simulator.stand(2), *simulator.strides(5), *simulator.stand(1)]
TRUTH = simulator.simulate(PIECES, seed=5, rate_hz=RATE_HZ)
COUNT = len(TRUTH)
ROLL = Options(roll_share=0.0)  # the simulated foot does not
ERROR_M = 0.1  # in 6.75 m
COUNTS = 1.0 / units.m_s2_from_counts(1.0), 1.0 / np.radians(units.deg_s_from_counts(1.0))
ACC_OFFSET, GYRO_OFFSET, GYRO_XY = (800, -1600, 400), (-400, 0, 240), 1000  # 1/8 counts, 1/65536
TOLD = {f"acc_offset_q3_{at}": each for at, each in enumerate(ACC_OFFSET)}
TOLD |= {f"gyro_offset_q3_{at}": each for at, each in enumerate(GYRO_OFFSET)}
TOLD |= {"gyro_xy_q16": GYRO_XY, "imu_every": 1}


@dataclass
class FootImu(FakeImu):
    """An IMU on a foot that walks; it measures with the errors that TOLD takes off."""

    every: int = 1
    walk: simulator.Walk = field(default_factory=lambda: TRUTH)
    errs: bool = True
    before: int = 0  # samples that were taken before the walk's first

    def _measured(self):
        at = min(self.number - self.before, len(self.walk)) - 1
        acc = self.walk.acc_b_m_s2[at] * COUNTS[0]
        gyro = self.walk.gyro_b_rad_s[at] * COUNTS[1]
        if self.errs:
            acc = acc + np.array(ACC_OFFSET) / 8
            gyro = gyro + np.array(GYRO_OFFSET) / 8
            gyro[0] -= gyro[1] * GYRO_XY / 65536
        limit = np.iinfo(np.int16)
        return [
            np.clip(np.rint(each), limit.min, limit.max).astype(int).tolist()
            for each in (acc, gyro)
        ]


def capture(folder, *, imu=None, told=TOLD, count=COUNT, name="foot.terazi", **how):
    maker = CaptureMaker(folder / name).hello()
    if told is not None:
        maker.settings(**told)
    imu = imu or FootImu(
        acc=ImuCal(offset_q3=ACC_OFFSET),
        gyro=ImuCal([[0, GYRO_XY, 0], [0, 0, 0], [0, 0, 0]], GYRO_OFFSET),
    )
    return maker.imu(imu, count, **how).end()


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return capture(tmp_path_factory.mktemp("captures"))


def error_m(walk, options=ROLL):
    known = replace(walk, truth=replace(TRUTH.truth, at=TRUTH.truth.at[: len(walk)]))
    known = replace(known, truth=replace(known.truth, pos_t_m=TRUTH.truth.pos_t_m[: len(walk)]))
    return path_errors(known, estimate(walk, options).path.pos_w_m).rmse_3d_m


def test_samples_come_out_calibrated_in_si_on_the_device_s_clock(path):
    walk = load_walk(path)
    assert (walk.name, walk.rate_hz, walk.notes) == ("foot", RATE_HZ, ())
    assert len(walk) == len(TRUTH)
    assert np.allclose(walk.t_s, np.arange(len(TRUTH)) / RATE_HZ, atol=1e-6)
    assert np.abs(walk.acc_b_m_s2 - TRUTH.acc_b_m_s2).max() < 1.5 / COUNTS[0]
    assert np.abs(walk.gyro_b_rad_s - TRUTH.gyro_b_rad_s).max() < 1.5 / COUNTS[1]


@pytest.mark.parametrize("causal", [False, True])
@pytest.mark.parametrize("detector", ["adaptive_shoe", "device"])
def test_its_path_is_the_foot_s(path, detector, causal):
    options = replace(ROLL, detector=detector, causal=causal)
    assert error_m(load_walk(path), options) < ERROR_M


def test_without_settings_samples_are_taken_as_they_are_and_a_note_says_so(tmp_path):
    walk = load_walk(capture(tmp_path, imu=FootImu(errs=False), told=None))
    assert np.abs(walk.acc_b_m_s2 - TRUTH.acc_b_m_s2).max() < 1.0 / COUNTS[0]
    assert [note for note in walk.notes if "calibration" in note]
    assert walk.device.detector == "unknown"


def test_a_capture_is_known_by_its_content_whatever_its_name(path, tmp_path):
    other = tmp_path / "monday.csv"
    other.write_bytes(path.read_bytes())
    assert len(load_walk(other)) == len(TRUTH)


def test_a_layout_or_a_rate_is_refused_for_what_tells_its_own(path):
    for asked in ({"rate_hz": 200.0}, {"layout": path}):
        with pytest.raises(UsageError, match="for a CSV"):
            load_walk(path, **asked)


def test_1_khz_is_read_as_1_khz(tmp_path):
    quick = simulator.simulate(PIECES, seed=5, rate_hz=1000)
    imu = FootImu(walk=quick, rate_hz=1000, errs=False)
    walk = load_walk(capture(tmp_path, imu=imu, told={"imu_mode": 2, "imu_every": 1}, count=4000))
    assert walk.rate_hz == 1000
    assert np.abs(walk.acc_b_m_s2 - quick.acc_b_m_s2[:4000]).max() < 1.0 / COUNTS[0]


# What is missing.


def drop(*numbers):
    return lambda message: isinstance(message, Imu) and message.sample in numbers


def test_single_samples_that_are_missing_lie_on_straight_lines_and_are_told(tmp_path, path):
    walk = load_walk(capture(tmp_path, drop=drop(100, 1500, 1501, 1502)))
    assert len(walk) == len(TRUTH)
    (note,) = walk.notes
    assert "4 of 4250 samples" in note
    assert "at most 0.008 s at a time, at 3.00 s" in note
    whole = load_walk(path)
    apart = np.flatnonzero((walk.acc_b_m_s2 != whole.acc_b_m_s2).any(axis=1))
    assert set(apart) <= {99, 1499, 1500, 1501}
    between = (whole.acc_b_m_s2[1498] + whole.acc_b_m_s2[1502]) / 2
    assert np.allclose(walk.acc_b_m_s2[1500], between)
    assert error_m(walk) < ERROR_M


def test_a_line_that_is_too_slow_is_refused_with_the_rate_that_would_do(tmp_path):
    slow = capture(tmp_path, drop=lambda message: getattr(message, "sample", 1) % 10 == 0)
    with pytest.raises(CannotRead, match=r"of .* samples are missing") as refused:
        load_walk(slow)
    assert "terazi set uart.baud=500000" in refused.value.remedy


def test_behind_a_hole_nothing_is_known_so_the_longest_stretch_is_read(tmp_path):
    hole = capture(tmp_path, drop=lambda one: 900 <= getattr(one, "sample", 1) < 1000)
    walk = load_walk(hole)
    assert len(walk) == len(TRUTH) - 999
    assert "1.8 s are left out" in walk.notes[0]
    assert np.allclose(walk.acc_b_m_s2[-1], TRUTH.acc_b_m_s2[-1], atol=1.5 / COUNTS[0])


def test_numbers_of_16_bits_wrap_and_the_walk_goes_on(tmp_path):
    imu = FootImu(errs=False, number=65_000, before=65_000)
    walk = load_walk(capture(tmp_path, imu=imu, told={"imu_every": 1}, count=2000))
    assert (len(walk), walk.notes) == (2000, ())
    assert np.abs(walk.acc_b_m_s2 - TRUTH.acc_b_m_s2[:2000]).max() < 1.0 / COUNTS[0]


def test_of_two_starts_of_the_device_the_longer_is_read(tmp_path):
    maker = CaptureMaker(tmp_path / "twice.terazi").hello().settings(imu_every=1)
    maker.imu(FootImu(errs=False), 1100).hello()
    walk = load_walk(maker.imu(FootImu(errs=False), 2500).end())
    assert len(walk) == 2500
    assert "of 2 stretches between holes the longest is read" in walk.notes[0]
    assert "2.2 s are left out" in walk.notes[0]


def test_samples_that_the_device_missed_count_as_time(tmp_path):
    walk = load_walk(
        capture(tmp_path, imu=FootImu(errs=False), told=None, count=2000, lost={700: 5})
    )
    assert len(walk) == 2005
    assert "5 of 2005" in walk.notes[0]


def test_rare_samples_are_told_and_very_rare_ones_refused(tmp_path):
    fifth = capture(tmp_path, imu=FootImu(every=5, errs=False), told={"imu_every": 5})
    walk = load_walk(fifth)
    assert walk.rate_hz == 100
    assert "one in 5 samples was recorded" in walk.notes[0]
    assert "imu.every=1" in walk.notes[0]
    rare = capture(tmp_path, imu=FootImu(every=20), told={"imu_every": 20}, name="rare.terazi")
    with pytest.raises(CannotRead, match="25 a second") as refused:
        load_walk(rare)
    assert "imu.every=1" in refused.value.remedy


@pytest.mark.parametrize(("told", "words"), [(TOLD, "log --imu"), ({"imu_mode": 0}, "imu.mode")])
def test_without_samples_of_an_imu_it_says_how_to_record_them(tmp_path, told, words):
    maker = CaptureMaker(tmp_path / "scale.terazi").hello().settings(**told)
    with pytest.raises(CannotRead, match="holds no samples of an IMU") as refused:
        load_walk(maker.samples(200).end())
    assert words in refused.value.remedy
    assert "terazi log --imu" in refused.value.remedy


def test_samples_on_a_rail_are_counted_for_each_sensor(tmp_path):
    def railed(message):
        if isinstance(message, Imu) and message.sample in (1200, 1201, 1300):
            return replace(message, acc_y_counts=-32768)
        if isinstance(message, Imu) and message.sample == 1400:
            return replace(message, gyro_z_counts=32767)
        return message

    notes = load_walk(capture(tmp_path, change=railed)).notes
    assert [note.split(",")[0] for note in notes] == [
        "3 samples are beyond 16 g",
        "1 samples are beyond 2000 deg/s",
    ]


def test_another_protocol_s_capture_is_refused(tmp_path):
    maker = CaptureMaker(tmp_path / "old.terazi")
    maker.say(replace(maker.chain.hello(), protocol_fingerprint=0x1234))
    with pytest.raises(FingerprintMismatch):
        load_walk(maker.end())


# The device's own detector.


@pytest.mark.parametrize(
    "name", [name for name, _ in SETTINGS_BY_NAME["imu.zupt"].choices if name != "off"]
)
def test_the_device_s_detector_is_named_as_its_setting_names_it(tmp_path, name):
    number = dict(SETTINGS_BY_NAME["imu.zupt"].choices)[name]
    told = {**TOLD, "imu_zupt": number}
    walk = load_walk(capture(tmp_path, told=told, count=1100))
    detection = estimate(walk, replace(ROLL, detector="device")).detection
    assert detection.detector == f"device ({name})"


def test_what_the_device_said_is_told_sample_by_sample_and_its_delay_taken_off(path):
    walk = load_walk(path)
    late = round(walk.device.late_s * walk.rate_hz)
    assert late == 15
    causal = estimate(walk, replace(ROLL, detector="device", causal=True)).detection.still
    recorded = estimate(walk, replace(ROLL, detector="device")).detection.still
    assert np.array_equal(causal, walk.device.still)
    assert np.array_equal(recorded[:-late], causal[late:])
    begun = slice(100, None)  # its first blocks have passed
    agree = [np.mean(one[begun] == TRUTH.zero_velocity[begun]) for one in (causal, recorded)]
    assert agree[0] < agree[1]


def test_where_the_device_said_nothing_its_detector_is_refused_with_the_reason(tmp_path, path):
    options = replace(ROLL, detector="device")
    off = capture(tmp_path, told={**TOLD, "imu_zupt": 0}, count=1100)
    with pytest.raises(CannotRead, match=r"imu\.zupt was off"):
        estimate(load_walk(off), options)
    silent = capture(
        tmp_path, drop=lambda one: isinstance(one, Attitude), count=1100, name="b.terazi"
    )
    with pytest.raises(CannotRead, match="no ATTITUDE was streamed"):
        estimate(load_walk(silent), options)
    with pytest.raises(CannotRead, match="only a capture"):
        estimate(TRUTH, options)
    with pytest.raises(UsageError, match="threshold"):
        estimate(load_walk(path), replace(options, threshold=0.3))


def test_an_attitude_that_is_missing_says_what_the_one_before_said(tmp_path, path):
    rare = capture(tmp_path, drop=lambda one: isinstance(one, Attitude) and one.sample % 4 != 1)
    walk, whole = load_walk(rare), load_walk(path)
    assert "lack their ATTITUDE" in walk.notes[0]
    assert np.array_equal(walk.device.still, np.repeat(whole.device.still[::4], 4)[: len(whole)])


# Tables beside a capture.


def write_tables(capture_path):
    tables, stream = Tables(capture_path, {}), MessageStream()
    for host_s, data in Capture(capture_path).chunks():
        for received in stream.feed(data, host_s):
            tables.add_message(received)
    tables.close()
    return table_paths(capture_path)["imu.csv"]


def test_the_table_of_imu_samples_is_read_uncalibrated_and_says_so(tmp_path):
    path = capture(tmp_path, imu=FootImu(errs=False), told=None)
    walk = load_walk(write_tables(path))
    assert walk.rate_hz == RATE_HZ
    assert np.abs(walk.acc_b_m_s2 - TRUTH.acc_b_m_s2).max() < 1.0 / COUNTS[0]
    assert np.abs(walk.gyro_b_rad_s - TRUTH.gyro_b_rad_s).max() < 1.0 / COUNTS[1]
    assert "the capture beside it" in walk.notes[0]


@pytest.mark.parametrize("name", ["foot.terazi", "monday"])
def test_in_a_folder_captures_are_walks_but_tables_beside_them_are_not(tmp_path, name):
    path = capture(tmp_path, count=1100, name=name)
    write_tables(path)
    (tmp_path / "other.csv").write_text("words")
    (tmp_path / "words.txt").write_text("words")
    (tmp_path / "folder.npz").mkdir()
    assert find_walks(tmp_path) == sorted([path, tmp_path / "other.csv"])


def test_files_of_one_name_are_refused_for_results_bear_it(tmp_path):
    (tmp_path / "a.csv").write_text("words")
    (tmp_path / "a.npz").write_text("words")
    with pytest.raises(CannotRead, match=r"a\.csv and a\.npz would bear one name"):
        find_walks(tmp_path)
    assert find_walks(tmp_path, "a.npz") == [tmp_path / "a.npz"]


# The command line.


def test_walk_and_score_take_captures_and_name_the_device_s_detector(path):
    shown = CliRunner().invoke(app, ["walk", str(path), "--detector", "device"])
    assert "by device (shoe)" in shown.stdout
    told = CliRunner().invoke(app, ["walk", str(path), "--detector", "device", "--json"])
    assert json.loads(told.stdout)["detector"] == "device (shoe)"
    found = CliRunner().invoke(app, ["walk", "score", str(path.parent), "--json"])
    scored = json.loads(found.stdout)["trials"]["foot"]
    assert scored["rmse_2d_m"] is scored["rmse_3d_m"] is None
    assert scored["closure_m"] == pytest.approx(6.75, rel=0.03)
    refused = CliRunner().invoke(
        app, ["walk", str(path), "--detector", "device", "--threshold", "1"]
    )
    assert refused.exit_code == 2
