# SPDX-License-Identifier: MIT
"""`terazi calibrate --imu`, `--mag`, `--level` and `--self-test` against the firmware: the whole
road from a part with known errors to what the board measures by after a reset."""

import numpy as np
import pytest

from host.tests.fake_bench import Script
from terazi.calibration.imu.axes import NAMES, turn_of
from terazi.calibration.imu.dialogue import Plan, calibrate_imu
from terazi.calibration.imu.level import set_level
from terazi.calibration.imu.rehearsal import FACES, SLANTS, Board, left_of
from terazi.calibration.imu.self_test import self_test, want_all
from terazi.control.settings import read_settings
from terazi.errors import CalibrationRefused
from terazi.link.generated.messages import ImuStatus, Weight

SEED = 4
RATE_HZ = 500.0
SELF_TEST_Z = 0x0F  # register map 4.1
READY_S = 1.0  # from now until the hands begin


class Hands(Board):
    """What a board feels while it is put on its sides, without the errors of its part."""

    def record(self, acc_g, rates_rad_s):
        self.acc_g, self.rates_deg_s = acc_g, np.degrees(rates_rad_s)


@pytest.fixture
def bench(uno):
    """The simulator, with an MPU-6050 that has noise."""
    bench = uno.truth("be turned about")
    bench.imu.fit().noise()
    uno.link.hello()
    return bench


def feel(bench, hands):
    """Lies as it begins until READY_S from now, and then as the hands have it."""
    still = round((bench.seconds + READY_S) * RATE_HZ)
    acc_g = np.vstack([np.tile(hands.acc_g[:1], (still, 1)), hands.acc_g])
    rates_deg_s = np.vstack([np.zeros((still, 3)), hands.rates_deg_s])
    bench.imu.feel(acc_g=(acc_g, RATE_HZ), gyro_deg_s=(rates_deg_s, RATE_HZ))


def started_anew(uno):
    uno.reset()
    uno.link.stream.hello = None
    uno.link.hello()


def test_lying_on_its_sides_calibrates_a_board_for_good(uno, bench):
    hands = Hands(SEED, rate_hz=RATE_HZ)
    hands.sitting([*FACES, *SLANTS])
    bench.imu.errors(
        gyro_bias_deg_s=hands.bias_deg_s,
        gyro_matrix=hands.gyro_k,
        acc_offset_g=hands.acc_offset_g,
        acc_matrix=hands.acc_k,
    )
    feel(bench, hands)
    before = read_settings(uno.link, ["imu.mode", "imu.every"])
    outcome = calibrate_imu(uno.link, Script("save"), Plan())
    left = left_of(hands, outcome.motion, SEED)
    assert left.offset_mg < 1.0
    assert left.scale_percent < 0.1
    assert left.gyro_percent < 0.2  # 16.4 counts a deg/s on the datasheet, 2^15 / 2000 in the C
    assert left.after_mg < 0.5 < 50 < left.before_mg
    bench.imu.feel(acc_g=hands.acc_g[-1], gyro_deg_s=(0.0, 0.0, 0.0))
    started_anew(uno)
    assert read_settings(uno.link, outcome.settings) == outcome.settings
    assert read_settings(uno.link, before) == before
    told = [one.message for one in uno.wait(4.0)]
    (*_others, status) = (one for one in told if isinstance(one, ImuStatus))
    up = np.array([status.up_x_q14, status.up_y_q14, status.up_z_q14]) / 2**14
    felt = hands.truth[1].T @ hands.acc_g[-1]  # in the axes of the calibrated sensor
    assert np.degrees(np.arctan2(np.linalg.norm(np.cross(up, felt)), up @ felt)) < 0.3
    assert any(isinstance(one, Weight) for one in told)


def test_a_board_that_is_left_alone_is_told_what_is_missing(uno, bench):
    bench.imu.feel(acc_g=(0.0, 1.0, 0.0))
    with pytest.raises(CalibrationRefused, match="missing: x up, x down, y down, z up, z down"):
        calibrate_imu(uno.link, Script(), Plan(asks=False, wait_s=4.0))
    assert not any(read_settings(uno.link, ["acc.xx_q16", "acc.offset_q3_0"]).values())


def test_turning_it_about_takes_iron_off_the_magnetometer(uno, bench):
    bench.mag.fit("qmc5883l")
    hard_ut, field_ut = np.array([12.0, -20.0, 6.0]), 48.0
    soft = np.array([[1.05, 0.03, 0.0], [0.03, 0.97, -0.02], [0.0, -0.02, 1.0]])

    def field(t_s):
        z = np.cos(np.pi * np.clip((t_s - 1.0) / 30.0, 0.0, 1.0))
        level, angle = np.sqrt(1 - z * z), 2.5 * t_s
        sphere = np.stack([level * np.cos(angle), level * np.sin(angle), z], axis=1)
        return field_ut * sphere @ soft + hard_ut

    bench.mag.feel(field)
    uno.wait(1.5)
    plan = Plan(motion=False, field=True, asks=False, wait_s=10.0)
    result = calibrate_imu(uno.link, Script(), plan).field
    counts_ut = 30.0  # 3000 a gauss
    assert result.mag.constants.offset_counts / counts_ut == pytest.approx(hard_ut, abs=0.3)
    assert result.rms_after < 0.01 < 0.1 < result.rms_before


@pytest.mark.parametrize("up", [(0, 0, -1), (0, 1, 0), (-1, 0, 0)])
def test_a_part_on_its_side_is_told_how_it_stands(uno, bench, up):
    bench.imu.feel(acc_g=up)
    found = set_level(uno.link, Script("save"), asks=True, wait_s=6.0)
    assert turn_of(found.imu_code) @ up == pytest.approx((0, 0, 1))
    started_anew(uno)
    assert read_settings(uno.link, ["imu.orientation"])["imu.orientation"] == found.imu_code
    assert found.imu_code in NAMES
    (*_others, status) = (
        one.message for one in uno.wait(4.0) if isinstance(one.message, ImuStatus)
    )
    assert status.up_z_q14 / 2**14 == pytest.approx(1.0, abs=0.01)


def test_a_good_part_passes_its_own_test_and_goes_on(uno, bench):
    answers = self_test(uno.link, Script())
    want_all(answers)
    assert all(one.code for one in answers), "an untrimmed part passes whatever it answers"
    assert max(abs(one.off) for one in answers) < 0.02
    assert [one.message for one in uno.wait(1.0) if isinstance(one.message, Weight)]


def test_a_part_that_answers_too_little_fails(uno, bench):
    uno.wait(0.5)  # it has been set up
    trim_z = bench.imu.registers[SELF_TEST_Z]
    bench.imu.set_register(SELF_TEST_Z, trim_z + 8)  # promises 1.046^8 times as much
    with pytest.raises(CalibrationRefused, match=r"the self-test fails: gyroscope z \(-30%\)"):
        want_all(self_test(uno.link, Script()))
