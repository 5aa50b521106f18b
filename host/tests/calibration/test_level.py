# SPDX-License-Identifier: MIT
"""How the IMU stands on its board, from the board lying as in use."""

import numpy as np
import pytest

from host.tests.calibration.imu_bench import bench_of, fill_line, sitting
from host.tests.fake_bench import Script
from terazi.calibration.imu.axes import NAMES, turn_of
from terazi.calibration.imu.level import find_level, set_level
from terazi.calibration.imu.rehearsal import FACES
from terazi.errors import CalibrationRefused
from terazi.link.generated.settings import SETTINGS_BY_NAME

IMU, MAG = (SETTINGS_BY_NAME[f"{part}.orientation"].key for part in ("imu", "mag"))


@pytest.mark.parametrize("up", FACES)
@pytest.mark.parametrize("imu", [8, 20, 53])
def test_whichever_axis_is_up_becomes_z(up, imu):
    found = find_level(np.add(up, (0.02, -0.01, 0.03)), imu, 33)
    assert turn_of(found.imu_code) @ up == pytest.approx((0, 0, 1))
    before = turn_of(imu).T @ turn_of(33)
    after = turn_of(found.imu_code).T @ turn_of(found.mag_code)
    assert np.array_equal(before, after), "the magnetometer has to turn along"
    assert 0 < found.off_deg < 3


@pytest.mark.parametrize("code", list(NAMES))
def test_what_stands_right_stays(code):
    up = turn_of(code).T @ (0, 0, 1)
    assert find_level(up, code, 8).settings == {"imu.orientation": code, "mag.orientation": 8}


def test_a_board_at_a_slant_is_refused():
    with pytest.raises(CalibrationRefused, match="x and z at a slant, 45 deg off"):
        find_level(np.array((1.0, 0, 1.0)), 8, 8)


def test_it_is_asked_for_set_and_saved():
    bench = bench_of(sitting(1, [(0, -1, 0)]))
    script = Script("save")
    found = set_level(bench.link, script, asks=True, wait_s=10.0)
    assert bench.eeprom.values[IMU] == found.imu_code != 8
    assert bench.eeprom.values[MAG] == found.mag_code
    assert "The part lies with y down" in script.text
    assert f"imu.orientation: px_py -> {NAMES[found.imu_code]}" in script.said


def test_nothing_is_saved_where_nothing_changes_or_nobody_wants_it():
    bench = bench_of(sitting(1, [(0, 0, 1)]))
    script = Script()
    set_level(bench.link, script, asks=True, wait_s=10.0)
    assert "It stands as imu.orientation says: px_py." in script.said
    other = bench_of(sitting(1, [(0, 0, -1)]))
    set_level(other.link, Script("leave"), asks=True, wait_s=10.0)
    set_level(other.link, Script(), asks=True, wait_s=10.0, dry_run=True)
    assert bench.eeprom.sequence == other.eeprom.sequence == 0
    assert other.chain.values[IMU] == 8


def test_a_board_that_never_lies_still_is_told():
    record = sitting(1, [(0, 0, 1)])
    shakes = np.random.default_rng(1).integers(-40, 40, len(record))
    record.gyro_b_counts[:, 2] += shakes.astype(np.int16)
    bench = bench_of(record)
    with pytest.raises(CalibrationRefused, match="does not lie still: it moves by"):
        set_level(bench.link, Script(), asks=False, wait_s=4.0)


def test_a_line_that_is_full_of_attitudes_is_no_hindrance():
    bench = fill_line(bench_of(sitting(1, [(0, 1, 0)])))
    found = set_level(bench.link, Script(), asks=False, wait_s=20.0)
    assert bench.chain.values[IMU] == found.imu_code != 8
