# SPDX-License-Identifier: MIT
"""The page's section on attitude: there where an IMU was recorded, and only there."""

import re

import pytest

from host.tests.captures import CaptureMaker
from host.tests.fake_imu import FakeImu
from terazi.link.generated.messages import Attitude
from terazi.recorder import load_recording
from terazi.report import analyse
from terazi.report.attitude import angles_over_time, section
from terazi.report.page import render


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("attitude")


@pytest.fixture(scope="module")
def recording(folder):
    """9 s at 500 Hz: rest, a turn by 90 deg in which two samples are missed, rest."""
    maker = CaptureMaker(folder / "one.terazi").hello().settings().samples(500)
    return load_recording(maker.imu(FakeImu(identity=0x70), 4500, lost={2000: 2}).end())


def test_page_without_an_imu_has_no_section_on_attitude(folder):
    path = CaptureMaker(folder / "none.terazi").hello().samples(200).end()
    recording = load_recording(path)
    assert section(recording) == ""
    assert "<h2>Attitude</h2>" not in render(recording, analyse(recording))


def test_page_shows_angles_stillness_bias_and_health(recording):
    page = section(recording)
    for words in ("roll", "pitch", "yaw", "at rest", "bias x", "gyroscope"):
        assert words in page, words
    assert "<td>attitudes</td><td>900, 100.1 a second</td>" in page
    assert re.search(r"<td>tilt at the end</td><td>(89|90)\.\d° off the vertical", page)
    assert '<td>samples lost</td><td><span class="never">1</span> of the attitudes</td>' in page
    assert '<td>missed</td><td><span class="never">2</span></td>' in page
    assert "that of an MPU-6500" in page
    assert "<h2>Attitude</h2>" in render(recording, analyse(recording))


def test_page_draws_what_was_told_on_the_weights_time(recording):
    drawn = {trace.name: trace for trace in angles_over_time(recording).data if trace.name}
    first_us = recording.samples["device_us"][0]
    assert drawn["roll"].x[0] == pytest.approx((10_000 - first_us) / 1e6, abs=1e-4)
    assert drawn["roll"].y[:100] == pytest.approx(0.0, abs=1.0)
    assert drawn["roll"].y[-1] == pytest.approx(90.0, abs=1.5)
    assert drawn["bias x"].y[-1] == pytest.approx(25 / 16.384, abs=0.1)
    bars = [trace for trace in angles_over_time(recording).data if not trace.name]
    rests = next(bar for bar in bars if bar.y[0] == "at rest")
    begins_s, ends_s = rests.x[0::3], rests.x[1::3]
    assert len(begins_s) == 2
    assert ends_s[0] == pytest.approx(3.0, abs=0.1)
    assert begins_s[1] > 5.0


def test_page_of_an_imu_that_had_no_attitude_yet_says_so(folder):
    maker = CaptureMaker(folder / "zeros.terazi").hello().samples(200)
    maker.say(Attitude(1, 0, 0, 0, 0, 0))
    assert "none yet" in section(load_recording(maker.end()))
