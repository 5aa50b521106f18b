# SPDX-License-Identifier: GPL-3.0-or-later
"""How the board is turned over time, for the pseudo-terminal program: what its IMU feels."""

import pathlib
import zipfile

import numpy as np

FIELD_UT = np.array([0.0, 20.0, -40.0])  # east, north, up: somewhere in Europe
REST_S = 3.0  # before anything moves
# BROAD's scales, where a file names no others.
USUAL = {
    "sampling_rate": 2000.0 / 7.0,
    "gyr_lsb_per_dps": 16.384,
    "acc_lsb_per_g": 2048.0,
    "mag_lsb_per_uT": 100.0,
}
BROAD, WALK = ("gyr", "acc", "mag"), ("imu", "ts")
GRAVITY_M_S2 = 9.80665  # of the unit g
EVEN = 0.5  # of a sample, by which a time may be off


class MotionError(ValueError):
    """The motion cannot be read; the message is one line for a person."""


class Motion:
    """``acc_g``, ``gyro_deg_s`` and ``field_ut``: each as ``Imu.feel`` takes it."""

    def __init__(self, acc_g, gyro_deg_s, field_ut):
        self.acc_g, self.gyro_deg_s, self.field_ut = acc_g, gyro_deg_s, field_ut


def read_motion(spec):
    """From the words ``still`` and ``rocking``, or ``FILE.npz`` in one of two formats.

    BROAD's: ``gyr``, ``acc`` and ``mag`` (n, 3) in counts; it may hold the scalars
    ``sampling_rate``, ``gyr_lsb_per_dps``, ``acc_lsb_per_g``, ``mag_lsb_per_uT``.
    A walk's, as ``terazi walk simulate`` writes: ``imu`` (n, 6) in m/s^2 and rad/s at the evenly
    spaced times ``ts`` (n,) in s, of which the first is the reset; the field stays as it is.
    """
    if spec == "still":
        return _turning(0.0)
    if spec == "rocking":
        return _turning(1.0)
    if not spec.endswith(".npz"):
        raise MotionError(f"motion {spec!r} is neither still, rocking nor FILE.npz")
    return _from_npz(pathlib.Path(spec))


def _turning(size):
    """At rest, then rolling, pitching and turning slowly to and fro, ``size`` times as far."""
    far_deg = size * np.array([20.0, 12.0, 40.0])  # roll, pitch, yaw
    rate_hz = np.array([0.25, 0.17, 0.05])

    def angles(t_s):
        phase = 2 * np.pi * rate_hz * np.maximum(t_s - REST_S, 0.0)[:, None]
        moving = (t_s > REST_S)[:, None]
        away = np.radians(far_deg) * (1 - np.cos(phase)) / 2
        speed = np.radians(far_deg) * np.pi * rate_hz * np.sin(phase) * moving
        return away.T, speed.T

    def acc_g(t_s):
        (roll, pitch, _yaw), _speed = angles(t_s)
        return _up_b(roll, pitch)

    def gyro_deg_s(t_s):
        (roll, pitch, _yaw), (rolls, pitches, yaws) = angles(t_s)
        x = rolls - yaws * np.sin(pitch)
        y = pitches * np.cos(roll) + yaws * np.sin(roll) * np.cos(pitch)
        z = yaws * np.cos(roll) * np.cos(pitch) - pitches * np.sin(roll)
        return np.degrees(np.stack([x, y, z], axis=1))

    def field_ut(t_s):
        (roll, pitch, yaw), _speed = angles(t_s)
        east, north, up = FIELD_UT
        ahead = np.cos(yaw) * east + np.sin(yaw) * north
        left = np.cos(yaw) * north - np.sin(yaw) * east
        x = np.cos(pitch) * ahead - np.sin(pitch) * up
        below = np.sin(pitch) * ahead + np.cos(pitch) * up
        y = np.cos(roll) * left + np.sin(roll) * below
        z = np.cos(roll) * below - np.sin(roll) * left
        return np.stack([x, y, z], axis=1)

    return Motion(acc_g, gyro_deg_s, field_ut)


def _up_b(roll, pitch):
    return np.stack(
        [-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)], axis=1
    )


def _from_npz(path):
    try:
        # The stream is ours to close: numpy forgets it where the archive is broken.
        with path.open("rb") as stream, np.load(stream) as arrays:
            names = set(arrays.files)
            wanted = WALK if set(WALK) <= names else (*BROAD, *USUAL)
            held = {name: np.asarray(arrays[name], float) for name in wanted if name in names}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise MotionError(f"motion {path}: {error}") from error
    if held.keys() == set(WALK):
        return _of_walk(path, **held)
    if missing := [name for name in BROAD if name not in held]:
        raise MotionError(
            f"motion {path}: it has no {', '.join(missing)} (BROAD), nor imu and ts (a walk)"
        )
    if any(held[name].ndim != 2 or held[name].shape[1] != 3 for name in BROAD):
        raise MotionError(f"motion {path}: gyr, acc and mag must have three columns")
    rate_hz, gyro, acc, mag = (float(held.get(name, usual)) for name, usual in USUAL.items())
    return Motion(
        (held["acc"] / acc, rate_hz), (held["gyr"] / gyro, rate_hz), (held["mag"] / mag, rate_hz)
    )


def _of_walk(path, imu, ts):
    if imu.ndim != 2 or imu.shape[1] != 6 or ts.shape != imu.shape[:1] or len(ts) < 2:
        raise MotionError(f"motion {path}: imu must be (n, 6) and ts (n,), n > 1")
    if not (np.isfinite(imu).all() and np.isfinite(ts).all()):
        raise MotionError(f"motion {path}: it holds what is no number")
    period_s = (ts[-1] - ts[0]) / (len(ts) - 1)
    even_s = ts[0] + period_s * np.arange(len(ts))
    if period_s <= 0 or np.abs(ts - even_s).max() > EVEN * period_s:
        raise MotionError(f"motion {path}: its times are not evenly spaced")
    rate_hz = 1.0 / period_s
    return Motion(
        (imu[:, :3] / GRAVITY_M_S2, rate_hz), (np.degrees(imu[:, 3:]), rate_hz), tuple(FIELD_UT)
    )
