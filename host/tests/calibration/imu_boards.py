# SPDX-License-Identifier: MIT
"""Simulated boards with an IMU of known errors, which are put on their sides and turned about."""

import numpy as np

from terazi.applications.attitude.records import Record

ONE_G, GYRO_COUNTS = 2048.0, 16.384
ACC_NOISE_G = 400e-6 * np.sqrt(98 * 1.57)  # 400 ug/rtHz behind the low-pass of 98 Hz
GYRO_NOISE_DEG_S = 0.005 * np.sqrt(98 * 1.57)
FACES = [(0, 0, 1), (0, 0, -1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)]
SLANTS = [(1, 1, 0), (1, -1, 0), (0, 1, 1), (0, 1, -1), (1, 0, 1), (-1, 0, 1)]


def unit(vector):
    return np.asarray(vector, float) / np.linalg.norm(vector)


def turn(axis_angle):
    """Rotation matrix of a rotation vector (Rodrigues)."""
    angle = np.linalg.norm(axis_angle)
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = np.asarray(axis_angle) / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


class Board:
    """raw = K true + offset + noise, counts; K and offset from the seed unless they are given."""

    def __init__(
        self,
        seed=1,
        *,
        offset_g=0.08,
        scale=0.03,
        cross=0.02,
        bias_deg_s=20.0,
        rate_hz=250.0,
        noise=1.0,
    ):
        self.rng = np.random.default_rng(seed)
        self.rate_hz, self.noise = rate_hz, noise
        self.acc_k, self.gyro_k = (self._matrix(scale, cross) for _sensor in range(2))
        self.acc_offset_g = offset_g * self._signs()
        self.bias_deg_s = bias_deg_s * self._signs()

    def _signs(self):
        return self.rng.choice([-1.0, 1.0], 3)

    def _matrix(self, scale, cross):
        """Every error at its limit, signs by chance."""
        signs = self.rng.choice([-1.0, 1.0], (3, 3))
        return np.eye(3) + signs * (np.eye(3) * scale + (1 - np.eye(3)) * cross)

    @property
    def truth(self):
        """(M of the accelerometer, its turn Q against the board's axes): inv(K) = Q M."""
        flip = np.eye(3)[::-1]
        # QL decomposition by QR of the flipped matrix
        q, r = np.linalg.qr(np.linalg.inv(self.acc_k) @ flip)
        q, low = q @ flip, flip @ r @ flip
        signs = np.diag(np.sign(np.diag(low)))
        return signs @ low, q @ signs

    @property
    def gyro_truth(self):
        return self.truth[1].T @ np.linalg.inv(self.gyro_k)

    def sitting(self, ups, *, still_s=3.0, turn_s=2.0, tilt_deg=3.0, spin=True, bump=0.2):
        """The Record of lying with each of `ups` (body axes) up in turn, turned by hand between.

        tilt_deg : how far off each position is, by chance;  bump : g, while it is turned.
        """
        attitudes, rates, shocks = [], [], []
        now = self._attitude(ups[0], tilt_deg)
        for at in range(len(ups)):
            count = round(still_s * self.rate_hz)
            attitudes += [now] * count
            rates += [np.zeros(3)] * count
            shocks += [np.zeros(3)] * count
            if at + 1 == len(ups):
                break
            last = self._attitude(ups[at + 1], tilt_deg)
            middle = now @ turn(self.rng.normal(0, 0.6, 3)) if spin else now
            for begin, end in ((now, middle), (middle, last)):
                more = self._turned(begin, end, turn_s / 2)
                attitudes += [a for a, _r in more]
                rates += [r for _a, r in more]
                shocks += list(self.rng.normal(0, bump, (len(more), 3)))
            now = last
        ups_b = np.array([a.T @ (0, 0, 1.0) for a in attitudes])
        return self.record(ups_b + np.array(shocks), np.array(rates))

    def _attitude(self, up, tilt_deg):
        """Body to world, with `up` nearly up and any heading."""
        up = unit(unit(up) + np.radians(tilt_deg) / np.sqrt(2) * self.rng.normal(size=3))
        level = unit(np.cross(up, unit(self.rng.normal(size=3))))
        return np.array([level, np.cross(up, level), up])

    def _turned(self, begin, end, seconds):
        """Attitudes and rates of one smooth turn about one axis; rad/s."""
        between = begin.T @ end
        angle = np.arccos(np.clip((np.trace(between) - 1) / 2, -1, 1))
        if angle < 1e-6:
            axis = np.array([1.0, 0, 0])
        elif angle > np.pi - 1e-3:  # then the skew part says little
            axis = unit(np.linalg.eigh(between + between.T)[1][:, -1])
        else:
            skew = between - between.T
            axis = unit((skew[2, 1], skew[0, 2], skew[1, 0]))
        t = (np.arange(round(seconds * self.rate_hz)) + 1) / round(seconds * self.rate_hz)
        way = t**3 * (10 - 15 * t + 6 * t * t)
        speed = 30 * t * t * (1 - t) ** 2 / seconds
        return [
            (begin @ turn(axis * angle * w), axis * angle * v)
            for w, v in zip(way, speed, strict=True)
        ]

    def record(self, acc_g, rates_rad_s):
        """Raw counts of what the board feels, in its own axes."""
        n = len(acc_g)
        acc = acc_g @ self.acc_k.T + self.acc_offset_g
        acc += self.noise * self.rng.normal(0, ACC_NOISE_G, (n, 3))
        gyro = np.degrees(rates_rad_s) @ self.gyro_k.T + self.bias_deg_s
        gyro += self.noise * self.rng.normal(0, GYRO_NOISE_DEG_S, (n, 3))
        sensors = counts(gyro * GYRO_COUNTS), counts(acc * ONE_G)
        return Record("simulated", self.rate_hz, np.arange(n), 1, *sensors)


def counts(values):
    return np.clip(np.rint(values), -32768, 32767).astype(np.int16)
