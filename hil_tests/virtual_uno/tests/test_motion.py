# SPDX-License-Identifier: GPL-3.0-or-later
"""What the IMU feels in the motions that the pseudo-terminal program offers."""

import numpy as np
import pytest

from virtual_uno.motion import REST_S, MotionError, read_motion
from virtual_uno.signals import as_vectors

STEP_S = 1e-4


@pytest.mark.parametrize("felt", ["acc_g", "field_ut"])
def test_what_stands_still_in_the_world_turns_against_the_gyroscope(felt):
    motion = read_motion("rocking")
    t_s = np.linspace(REST_S + 0.01, 60.0, 2000)
    vector = getattr(motion, felt)
    change = (vector(t_s + STEP_S) - vector(t_s - STEP_S)) / (2 * STEP_S)
    turned = np.cross(vector(t_s), np.radians(motion.gyro_deg_s(t_s)))
    scale = np.linalg.norm(vector(t_s), axis=1).max()
    assert np.abs(change - turned).max() < 1e-5 * scale
    assert np.linalg.norm(motion.gyro_deg_s(t_s), axis=1).max() > 10.0


def test_at_first_and_in_the_still_motion_nothing_turns():
    t_s = np.linspace(0.0, REST_S, 100)
    for word in ("still", "rocking"):
        motion = read_motion(word)
        assert not motion.gyro_deg_s(t_s).any()
        assert np.allclose(motion.acc_g(t_s), [0.0, 0.0, 1.0])


def test_a_recording_is_scaled_to_what_the_parts_feel(tmp_path):
    rows = np.tile([2048.0, 0.0, -1024.0], (30, 1))
    np.savez(tmp_path / "a.npz", gyr=rows, acc=rows, mag=rows, sampling_rate=100.0)
    motion = read_motion(str(tmp_path / "a.npz"))
    at_s = np.array([0.1])
    assert np.allclose(as_vectors(motion.acc_g)(at_s), [[1.0, 0.0, -0.5]])
    assert np.allclose(as_vectors(motion.gyro_deg_s)(at_s), [[125.0, 0.0, -62.5]])
    assert np.allclose(as_vectors(motion.field_ut)(at_s), [[20.48, 0.0, -10.24]])


def test_a_walk_is_scaled_to_what_the_parts_feel(tmp_path):
    rows = np.tile([9.80665, 0.0, -4.903325, np.pi, 0.0, -np.pi / 2], (30, 1))
    rows[20:] *= 2
    np.savez(tmp_path / "w.npz", imu=rows, ts=5.0 + np.arange(30) / 200, best_detector="shoe")
    motion = read_motion(str(tmp_path / "w.npz"))
    at_s = np.array([0.0, 19.5 / 200, 1.0])
    expected = np.array([[1.0], [1.5], [2.0]])
    assert np.allclose(as_vectors(motion.acc_g)(at_s), expected * [1.0, 0.0, -0.5])
    assert np.allclose(as_vectors(motion.gyro_deg_s)(at_s), expected * [180.0, 0.0, -90.0])
    assert np.ptp(as_vectors(motion.field_ut)(at_s), axis=0).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"imu": np.zeros((30, 5))}, r"imu must be \(n, 6\)"),
        ({"ts": np.arange(29) / 200}, r"ts \(n,\)"),
        ({"ts": np.arange(30) ** 2 / 200}, "not evenly spaced"),
        ({"ts": np.zeros(30)}, "not evenly spaced"),
        ({"imu": np.full((30, 6), np.nan)}, "no number"),
    ],
)
def test_a_walk_that_is_none_is_refused_in_a_line(tmp_path, changed, words):
    path = tmp_path / "w.npz"
    np.savez(path, **{"imu": np.zeros((30, 6)), "ts": np.arange(30) / 200, **changed})
    with pytest.raises(MotionError, match=words):
        read_motion(str(path))


def test_what_is_no_motion_is_refused_in_a_line(tmp_path):
    np.savez(tmp_path / "a.npz", gyr=np.zeros((3, 3)))
    (tmp_path / "c.npz").write_bytes(b"PK\x03\x04 cut off")
    for spec, words in (
        ("dancing", "neither still, rocking nor FILE.npz"),
        (str(tmp_path / "a.npz"), "it has no acc, mag"),
        (str(tmp_path / "b.npz"), "No such file"),
        (str(tmp_path / "c.npz"), "c.npz: "),
    ):
        with pytest.raises(MotionError, match=words):
            read_motion(spec)
