# SPDX-License-Identifier: MIT
"""A recording's attitudes over time: the device's own, or made here, and the page of them."""

import json
import subprocess
import sys

import numpy as np
import pytest

from host.tests.applications.synthetic import write
from host.tests.captures import CaptureMaker
from host.tests.fake_imu import BIAS_COUNTS, FIELD_COUNTS, FakeImu
from terazi.applications import attitude
from terazi.applications.attitude.page import render
from terazi.applications.attitude.summary import plain
from terazi.applications.attitude.view import load_view
from terazi.cshared import ImuCal
from terazi.errors import CannotRead, UsageError
from terazi.link.generated.messages import Attitude, Imu
from terazi.recorder.inertial import numbered

COUNT = 4000  # 8 s at 500 Hz: rest, a turn of 90 deg about x from 3 to 5 s, rest


def terazi(*words):
    command = [sys.executable, "-m", "terazi", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120)


@pytest.fixture(scope="module")
def trial(tmp_path_factory):
    return write(tmp_path_factory.mktemp("trials") / "one.npz", rest_s=4.0, move_s=8.0)


def capture(tmp_path, *, imu=None, told=None, without=(), **how):
    maker = CaptureMaker(tmp_path / "one.terazi").hello()
    if told is not None:
        maker.settings(**told)
    imu = imu or FakeImu(every=5)
    return maker.imu(imu, COUNT, drop=lambda one: isinstance(one, without), **how).end()


# A trial with a truth.


@pytest.mark.parametrize("mode", [6, 9])
def test_a_trials_errors_are_those_of_the_score(trial, mode):
    view = load_view(trial, mode=mode)
    (errors,) = attitude.score(
        [attitude.load_trial(trial)],
        lambda one: attitude.estimate(one, mode=mode),
        heading_is_free=mode == 6,
    ).trials.values()
    found = plain(view)["errors"]
    for name, value in vars(errors).items():
        assert found[name] == pytest.approx(value, rel=0.01)
    inclination = view.error_deg["inclination"][attitude.load_trial(trial).scored]
    assert np.sqrt(np.mean(inclination**2)) == pytest.approx(errors.inclination_rmse_deg, rel=0.01)


def test_a_trial_shows_rest_bias_and_field(trial):
    view = load_view(trial)
    resting = (view.t_s > 3) & (view.t_s < 4)
    moving = (view.t_s > 5) & (view.t_s < 11)
    assert view.flags["rest"][resting].all()
    assert not view.flags["rest"][moving].any()
    assert not view.flags["still"][moving].all()
    assert plain(view)["bias_deg_s"] == pytest.approx((0.4, -0.3, 0.6), abs=0.03)
    assert plain(view)["field_ut"]["mean"] == pytest.approx(np.hypot(19, 46), rel=0.01)
    assert "computed here" in view.source


def test_rates_of_the_attitude_are_those_of_the_gyroscope_less_its_bias(trial):
    view = load_view(trial)
    moving = slice(round(5 * view.rate_hz), round(11 * view.rate_hz))
    away = (
        view.rate_of_quat_deg_s[moving] - (view.sensors.rate_b_deg_s - (0.4, -0.3, 0.6))[1:][moving]
    )
    assert np.sqrt(np.mean(away**2)) < 0.5


def test_an_npz_without_truth_or_magnetometer_will_do(tmp_path):
    path = write(tmp_path / "bare.npz", without=("mag", "quat", "movement"), rest_s=2, move_s=2)
    view = load_view(path)
    assert view.errors is None
    assert view.sensors.mag_b_ut is None
    with pytest.raises(UsageError, match="holds no magnetometer"):
        load_view(path, mode=9)


# Captures.


def test_a_captures_attitudes_are_the_devices_own(tmp_path):
    view = load_view(capture(tmp_path))
    assert view.source == "the device's own"
    assert view.rate_hz == pytest.approx(100.0)
    roll, pitch, yaw = view.euler_deg[-1]
    assert (roll, pitch, yaw) == pytest.approx((90, 0, 0), abs=1.0)
    assert view.flags["rest"][view.t_s < 2.8][-50:].all()
    assert not view.flags["rest"][(view.t_s > 3.1) & (view.t_s < 4.9)].any()
    expected = np.array(BIAS_COUNTS) / 16.384
    assert view.bias_deg_s[-1] == pytest.approx(expected, abs=0.05)
    assert view.share("heading") == 0
    turning = (view.t_s > 3.2) & (view.t_s < 4.8)
    assert np.median(view.rate_of_quat_deg_s[turning[1:], 0]) == pytest.approx(45, abs=0.5)
    measured = view.sensors.rate_b_deg_s[(view.sensors.t_s > 3.2) & (view.sensors.t_s < 4.8), 0]
    assert np.median(measured) == pytest.approx(45 + expected[0], abs=0.2)


def test_raw_samples_alone_give_what_the_device_made_of_them(tmp_path):
    (tmp_path / "a").mkdir()
    device = load_view(capture(tmp_path / "a", imu=FakeImu(every=1)))
    here = load_view(capture(tmp_path, imu=FakeImu(every=1), without=Attitude))
    assert "computed here" in here.source
    assert here.quat_wb == pytest.approx(device.quat_wb, abs=1e-6)
    assert any("no SETTING" in note for note in here.notes)


def test_told_calibrations_are_applied_to_what_is_shown(tmp_path):
    told = {f"acc_offset_q3_{at}": value for at, value in enumerate((800, -400, 160))}
    told |= {f"gyro_offset_q3_{at}": 8 * value for at, value in enumerate(BIAS_COUNTS)}
    imu = FakeImu(every=5, acc=ImuCal(offset_q3=(800, -400, 160)))
    view = load_view(capture(tmp_path, imu=imu, told=told))
    still = view.sensors.t_s < 2.9
    assert np.abs(view.sensors.rate_b_deg_s[still].mean(axis=0)).max() < 0.1
    assert view.sensors.acc_b_g[still].mean(axis=0) == pytest.approx(
        (-100 / 2048, 50 / 2048, 1 - 20 / 2048), abs=0.002
    )
    assert not view.notes


def test_a_magnetometers_field_is_in_microtesla(tmp_path):
    view = load_view(capture(tmp_path, imu=FakeImu(every=5, mag_every=10)))
    assert plain(view)["field_ut"]["mean"] == pytest.approx(
        np.linalg.norm(FIELD_COUNTS) / 30, abs=0.1
    )
    assert view.share("heading") > 0.9


def test_the_fastest_turn_is_no_jump_of_a_filter_that_starts(tmp_path):
    (tmp_path / "a").mkdir()
    for view in (
        load_view(capture(tmp_path / "a", without=Imu)),
        load_view(capture(tmp_path, imu=FakeImu(every=1), without=Attitude)),
    ):
        assert plain(view)["rate_most_deg_s"] == pytest.approx(45, abs=4.0)


def test_small_angles_are_not_told_by_quarters(tmp_path):
    view = load_view(capture(tmp_path))
    assert np.ptp(view.euler_deg) < 180
    assert '"dtick":90' not in render(view)


def test_without_raw_samples_the_page_shows_the_attitudes_own_rates(tmp_path):
    view = load_view(capture(tmp_path, without=Imu))
    assert view.sensors is None
    text = render(view)
    assert "raw samples were not recorded" in text
    assert "<h2>Magnetometer</h2>" not in text


def test_what_went_wrong_is_told(tmp_path):
    view = load_view(capture(tmp_path, lost={2000: 30}))
    assert plain(view)["trouble"]["missed"] == 30
    assert view.flags["gap"].sum() == 1
    assert "samples lost" in render(view)


def test_a_capture_without_an_imu_says_how_to_record_one(tmp_path):
    path = CaptureMaker(tmp_path / "scale.terazi").hello().samples(50).end()
    with pytest.raises(CannotRead, match="neither ATTITUDE nor IMU") as caught:
        load_view(path)
    assert "terazi log --imu" in caught.value.remedy


# The page and the command.


def test_the_page_holds_every_section_and_no_network(trial):
    text = render(load_view(trial))
    for title in (
        "Angles",
        "Rest and events",
        "Rates",
        "Bias",
        "Acceleration",
        "Magnetometer",
        "Error",
        "Figures",
    ):
        assert f"<h2>{title}</h2>" in text
    assert "default-src 'none'" in text
    assert 'src="http' not in text


def test_a_file_in_place_of_a_verb_is_shown(trial, tmp_path):
    page = tmp_path / "one.html"
    done = terazi("attitude", trial, "-o", page)
    assert done.returncode == 0, done.stderr
    assert "inclination error" in done.stdout
    assert page.stat().st_size > 1_000_000
    told = json.loads(terazi("attitude", "file", trial, "--json", "--mode", "9").stdout)
    assert told["errors"]["heading_rmse_deg"] < 5
    assert told["share_of_time"]["rest"] > 0.2


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["alan"], 9, "there is no file alan"),
        (["{trial}", "-o", "{trial}"], 2, "would overwrite"),
        (["{trial}", "--mode", "7"], 2, "--mode is 6 or 9"),
        (["allan", "{trial}"], 9, "too short"),
        (["allan", "{trial}", "--begin", "99"], 2, "it lasts from 0 to 16.0 s"),
    ],
)
def test_what_makes_no_sense_is_one_line(trial, words, code, said):
    done = terazi("attitude", *(word.format(trial=trial) for word in words))
    assert done.returncode == code, done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_allan_of_a_capture_and_its_page(tmp_path):
    imu = FakeImu(every=5)
    maker = CaptureMaker(tmp_path / "still.terazi").hello()
    # It lies until 3 s, and from 5 s on.
    path = maker.imu(imu, 500 * 70, drop=lambda one: isinstance(one, Attitude)).end()
    moved = terazi("attitude", "allan", path)
    assert moved.returncode == 9
    assert "moves: at" in moved.stderr
    page = tmp_path / "still.html"
    done = terazi("attitude", "allan", path, "--begin", "6", "-o", page, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["rate_hz"] == pytest.approx(100.0)
    assert "one in 5 samples was recorded" in told["notes"][0]
    noise = (9 + 1 / 12) ** 0.5 / 16.384 / 100**0.5  # 3 counts rms at 100 samples a second
    for axis in told["gyro"].values():
        assert axis["angle_random_walk_deg_rth"] == pytest.approx(60 * noise, rel=0.05)
    assert "Allan deviation" in page.read_text("utf-8")


@pytest.mark.parametrize(
    ("sample", "steps"),
    [
        ([65534, 65535, 0, 1], [1, 1, 1]),  # it wraps
        ([5, 6, 7, 8], [1, 250, 1]),  # away for half a second, and counts on
        ([900, 901, 1, 2], [1, 3, 1]),  # set anew, and counts from 1
        ([10, 12, 16, 18], [2, 4, 2]),  # one in two, of which one is lost
    ],
)
def test_samples_are_numbered_by_their_count_or_by_the_clock(sample, steps):
    us = 1_000_000 + np.concatenate([[0], np.cumsum(steps)]) * 2000
    assert np.diff(numbered(np.array(sample, np.uint16), us)).tolist() == steps
