# SPDX-License-Identifier: MIT
"""The attitude chain replayed: agrees with what is right, finds one wrong bit, and says what it
cannot know."""

import dataclasses

import pytest

from host.tests.captures import CaptureMaker
from host.tests.fake_imu import FakeImu
from terazi.cshared import ImuCal
from terazi.link.generated.messages import Attitude, AttitudeFlag, Imu, Mag, Setting
from terazi.link.generated.settings import SettingKey
from terazi.recorder import load_recording
from terazi.replay import replay

COUNT = 2600  # 5.2 s at 500 Hz: rest, the turn, rest


@pytest.fixture
def maker(tmp_path):
    return CaptureMaker(tmp_path / "one.terazi").hello().samples(5)


def replayed(path, **more):
    result = replay(load_recording(path, **more))
    stages = {stage.stage: stage for stage in result.stages}
    whys = {one.why: one.samples for one in result.unverified if one.what == "attitude"}
    return result, stages, whys


def test_whole_recording_is_bit_identical_from_the_first_sample_on(maker):
    path = maker.settings(imu_every=1).imu(FakeImu(every=1), COUNT).end()
    result, stages, whys = replayed(path)
    assert result.is_bit_identical
    assert [stages[name].compared for name in ("attitude", "rest", "still")] == [COUNT] * 3
    assert whys == {}
    flags = load_recording(path).inertial.attitude["flags"]
    for flag in (AttitudeFlag.REST, AttitudeFlag.BIAS_KNOWN, AttitudeFlag.STILL):
        assert set(flags & int(flag)) == {0, int(flag)}, "else it would not say much"


def test_replay_uses_calibration_orientation_and_field_as_they_were_told(maker):
    imu = FakeImu(
        every=1,
        mag_every=7,
        acc=ImuCal([[900, 0, 0], [-150, 400, 0], [75, -60, 1300]], [160, -320, 80]),
        gyro=ImuCal([[500, 20, -30], [40, -500, 60], [-70, 80, 90]], [200, -112, 64]),
        mag=ImuCal([[2000, 100, -100], [100, -1500, 50], [-100, 50, 900]], [-800, 400, 320]),
        detector="are",
        orientation=0b000_010,  # the part's z is the board's x, its x the board's y
    )
    told = {
        **{"acc_xx_q16": 900, "acc_yx_q16": -150, "acc_yy_q16": 400},
        **{"acc_zx_q16": 75, "acc_zy_q16": -60, "acc_zz_q16": 1300},
        **{"gyro_xx_q16": 500, "gyro_xy_q16": 20, "gyro_xz_q16": -30},
        **{"gyro_yx_q16": 40, "gyro_yy_q16": -500, "gyro_yz_q16": 60},
        **{"gyro_zx_q16": -70, "gyro_zy_q16": 80, "gyro_zz_q16": 90},
        **{"mag_xx_q16": 2000, "mag_xy_q16": 100, "mag_xz_q16": -100},
        **{"mag_yx_q16": 100, "mag_yy_q16": -1500, "mag_yz_q16": 50},
        **{"mag_zx_q16": -100, "mag_zy_q16": 50, "mag_zz_q16": 900},
        **{f"acc_offset_q3_{axis}": (160, -320, 80)[axis] for axis in range(3)},
        **{f"gyro_offset_q3_{axis}": (200, -112, 64)[axis] for axis in range(3)},
        **{f"mag_offset_q3_{axis}": (-800, 400, 320)[axis] for axis in range(3)},
        **{"imu_orientation": 2, "mag_orientation": 2, "imu_every": 1, "imu_zupt": 2},
    }
    assert all(name.upper() in SettingKey.__members__ for name in told)
    result, stages, _whys = replayed(maker.settings(**told).imu(imu, COUNT).end())
    assert result.is_bit_identical
    assert stages["attitude"].compared == COUNT


@pytest.mark.parametrize(
    ("setting", "value"), [("imu_orientation", 2), ("acc_zz_q16", 900), ("gyro_offset_q3_1", 80)]
)
def test_replay_with_another_setting_differs(maker, setting, value):
    """So that the test before says something."""
    told = {"imu_every": 1, setting: value}
    result, stages, _whys = replayed(maker.settings(**told).imu(FakeImu(every=1), 400).end())
    assert not result.is_bit_identical
    assert stages["attitude"].differing > 300


def test_replay_finds_a_single_wrong_bit_and_says_where(maker):
    def bend(message):
        if isinstance(message, Attitude) and message.sample == 201:
            return dataclasses.replace(message, quat_y_q30=message.quat_y_q30 ^ 1)
        return message

    path = maker.settings(imu_every=1).imu(FakeImu(every=1), 400, change=bend).end()
    result, stages, _whys = replayed(path)
    assert not result.agrees
    assert stages["attitude"].differing == 1
    (first,) = stages["attitude"].first
    assert (first.sample, first.conversion) == (200, 201)
    assert abs(first.device - first.host) == 1


@pytest.mark.parametrize(
    ("flag", "stage"), [(AttitudeFlag.REST, "rest"), (AttitudeFlag.STILL, "still")]
)
def test_replay_finds_a_wrong_flag(maker, flag, stage):
    def deny(message):
        if isinstance(message, Attitude) and message.sample == 1300:
            return dataclasses.replace(message, flags=message.flags ^ flag)
        return message

    path = maker.settings(imu_every=1).imu(FakeImu(every=1), 1400, change=deny).end()
    _result, stages, _whys = replayed(path)
    differing = {name: stages[name].differing for name in ("attitude", "rest", "still")}
    assert differing == {"attitude": 0, "rest": 0, "still": 0} | {stage: 1}


def test_chain_is_followed_where_a_setting_lets_it_begin_anew(maker):
    """The field is kept; all else begins, with the settings that were told before."""
    imu = FakeImu(every=1, mag_every=10)
    maker.settings(imu_every=1).imu(imu, 703)
    maker.say(Setting(SettingKey.GYRO_OFFSET_Q3_0, 80))
    imu.gyro = ImuCal(offset_q3=(80, 0, 0))
    imu.begin_anew()
    result, stages, whys = replayed(maker.imu(imu, 300).end())
    assert result.is_bit_identical
    assert stages["attitude"].compared == 1003
    assert whys == {}


def test_an_imu_that_was_away_is_followed(maker):
    imu = FakeImu(every=1, mag_every=10)
    maker.settings(imu_every=1).imu(imu, 500)
    imu.go_away(0.31)
    maker.imu(imu, 300)
    imu.go_away(0.02)  # so short that only RESTARTED tells
    result, stages, whys = replayed(maker.imu(imu, 100).end())
    assert result.is_bit_identical
    assert stages["attitude"].compared == 900
    assert whys == {}


def test_a_magnetometer_that_goes_is_followed(maker):
    imu = FakeImu(every=1, mag_every=10)
    maker.settings(imu_every=1).imu(imu, 505)
    imu.lose_magnetometer()
    result, stages, _whys = replayed(maker.imu(imu, 300).end())
    assert result.is_bit_identical
    assert stages["attitude"].compared == 805


def test_a_recording_that_the_host_joins_late_is_verified_from_a_new_start_on(maker):
    imu = FakeImu(every=1)
    for _sample in range(50):
        imu.sample()
    maker.settings(imu_every=1).imu(imu, 100)
    imu.begin_anew()
    _result, stages, whys = replayed(maker.imu(imu, 200).end())
    assert stages["attitude"].compared == 200
    assert whys == {"recorded from mid-stream, the filter's state is unknown": 100}


def test_samples_that_the_device_missed_are_bridged_as_it_bridges_them(maker):
    path = maker.settings(imu_every=1)
    path = path.imu(FakeImu(every=1, mag_every=10), COUNT, lost={700: 3, 1500: 80, 1501: 1}).end()
    result, stages, whys = replayed(path)
    assert result.is_bit_identical
    assert stages["attitude"].compared == COUNT
    assert whys == {}


def test_behind_a_lost_frame_nothing_of_the_attitude_is_known(maker):
    path = maker.settings(imu_every=1)
    lose = lambda message: isinstance(message, Imu) and message.sample == 301  # noqa: E731
    result, stages, whys = replayed(path.imu(FakeImu(every=1), 400, drop=lose).end())
    assert result.is_bit_identical
    assert stages["attitude"].compared == 300
    assert whys == {"frames were lost on the way, and the filter's state with them": 100}


def test_a_lost_attitude_is_no_harm_to_the_others(maker):
    path = maker.settings(imu_every=1)
    lose = lambda message: isinstance(message, Attitude) and message.sample == 301  # noqa: E731
    result, stages, whys = replayed(path.imu(FakeImu(every=1), 400, drop=lose).end())
    assert result.is_bit_identical
    assert stages["attitude"].compared == 399
    assert whys == {}


def test_behind_a_lost_field_nothing_of_the_attitude_is_known(maker):
    path = maker.settings(imu_every=1)
    lose = lambda message: isinstance(message, Mag) and message.sample == 300  # noqa: E731
    result, stages, whys = replayed(path.imu(FakeImu(every=1, mag_every=10), 400, drop=lose).end())
    assert result.is_bit_identical
    assert stages["attitude"].compared == 299
    assert whys == {"frames were lost on the way, and the filter's state with them": 101}


@pytest.mark.parametrize(
    ("every", "settings", "drop", "why"),
    [
        (1, {"imu_every": 1}, Imu, "no raw sample was recorded; `terazi log --imu` does"),
        (1, None, None, "no SETTING tells how the IMU was set; `terazi log` asks for them"),
        (5, {}, None, "one in 5 samples was recorded, and imu.every=1 is needed"),
        (1, {"imu_every": 1, "imu_orientation": 0}, None, "no orientation 0 in imu_cal.h"),
        (1, {"imu_every": 1, "imu_mode": 3}, None, "imu.mode was none in which attitudes come"),
    ],
)
def test_what_cannot_be_verified_is_named_with_the_reason(maker, every, settings, drop, why):
    if settings is not None:
        maker.settings(**settings)
    told = FakeImu(every=every)
    maker.imu(told, 400, drop=lambda message: drop is not None and isinstance(message, drop))
    result, stages, whys = replayed(maker.end())
    assert result.agrees
    assert stages["attitude"].compared == 0
    assert whys == {why: 400 // every}


def test_recording_from_mid_stream_is_not_verified(maker):
    imu = FakeImu(every=1)
    for _sample in range(50):
        imu.sample()
    _result, stages, whys = replayed(maker.settings(imu_every=1).imu(imu, 100).end())
    assert stages["attitude"].compared == 0
    assert whys == {"recorded from mid-stream, the filter's state is unknown": 100}


def test_a_setting_that_changes_ends_what_is_known(maker):
    imu = FakeImu(every=1)
    maker.settings(imu_every=1).imu(imu, 100)
    maker.say(Setting(SettingKey.IMU_TILT_LIMIT_MRAD, 5))
    maker.imu(imu, 100)
    maker.say(Setting(SettingKey.GYRO_OFFSET_Q3_0, 5))
    _result, stages, whys = replayed(maker.imu(imu, 50).end())
    assert stages["attitude"].compared == 200
    assert whys == {"gyro.offset_q3_0 was changed while it was recorded": 50}


def test_sample_numbers_that_wrap_are_followed(maker):
    imu = FakeImu(every=1, mag_every=10)
    path = maker.settings(imu_every=1).imu(imu, 20, lost={5: 65_500}).imu(imu, 60).end()
    result, stages, _whys = replayed(path)
    assert result.is_bit_identical
    assert stages["attitude"].compared == 80


def test_board_without_a_scale_is_replayed_all_the_same(tmp_path):
    maker = CaptureMaker(tmp_path / "one.terazi").hello()
    path = maker.settings(imu_every=1).imu(FakeImu(every=1), 100).end()
    result, stages, _whys = replayed(path, needs_samples=False)
    assert result.agrees
    assert (result.samples, stages["fir"].compared, stages["attitude"].compared) == (0, 0, 100)
