# SPDX-License-Identifier: MIT
"""What a replay cannot judge is named, never passed over."""

import pytest

from host.tests.captures import CaptureMaker
from terazi.errors import FingerprintMismatch
from terazi.link.generated.messages import (
    FINGERPRINT,
    Ack,
    ChainOrder,
    KfKind,
    ResetSettings,
    Result,
    Setting,
)
from terazi.link.generated.settings import SettingKey
from terazi.recorder import load_recording
from terazi.replay import replay

HISTORY = "net weight and its flags"


@pytest.fixture
def maker(tmp_path):
    return CaptureMaker(tmp_path / "one.terazi")


def told(path):
    result = replay(load_recording(path))
    assert result.agrees
    return {one.what: one.samples for one in result.unverified}


def test_of_a_whole_recording_only_the_boards_past_is_unverified(maker):
    assert told(maker.hello().samples(300).end()) == {HISTORY: 300}


def test_a_mass_without_points_is_named(maker):
    path = maker.hello(points=False).samples(300).end()
    assert told(path) == {"mass": 300, HISTORY: 300}
    (mass,) = [one for one in replay(load_recording(path)).unverified if one.what == "mass"]
    assert str(mass).startswith("mass of 300 samples: no POINT tells the calibration")


def test_an_adaptive_filter_joined_in_mid_stream_is_named(maker):
    path = maker.hello().samples(400, drop=lambda index: index == 100).end()
    assert told(path) == {"FIR": 31, "adaptive Kalman": 299, HISTORY: 399}


def test_a_constant_filter_joined_in_mid_stream_is_named_until_its_gain_stands(tmp_path):
    maker = CaptureMaker(tmp_path / "one.terazi", kf_kind=KfKind.CONSTANT)
    found = told(maker.hello().samples(700, drop=lambda index: index == 100).end())
    assert found["FIR"] == 31
    assert 0 < found["Kalman"] < 300


def test_a_filter_set_by_key_is_followed_from_there(maker):
    maker.hello().samples(200)
    maker.chain.order = ChainOrder.KF_FIR
    maker.say(Setting(SettingKey.CHAIN_ORDER, ChainOrder.KF_FIR))
    result = replay(load_recording(maker.samples(200, restart=True).end()))
    assert result.agrees
    assert result.chains == ["fir_kf, adaptive", "kf_fir, adaptive"]


def test_after_a_reset_of_settings_nothing_is_certain_until_it_is_told(maker):
    maker.hello().samples(100)
    maker.say(Ack(command=ResetSettings.ID, command_sequence=0, result=Result.OK))
    found = told(maker.samples(50, restart=True).hello().samples(100, restart=True).end())
    assert found["all"] == 50


def test_a_capture_of_another_protocol_is_refused_with_the_version_that_reads_it(maker):
    maker.chain.fingerprint = FINGERPRINT ^ 1
    with pytest.raises(FingerprintMismatch, match=r"one\.terazi \(firmware 0\.1\.0\)") as caught:
        load_recording(maker.hello().samples(5).end())
    assert "It was recorded by terazi 0.1.0" in caught.value.remedy
    assert "flash" not in caught.value.remedy
