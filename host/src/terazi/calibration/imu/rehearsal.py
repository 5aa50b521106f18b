# SPDX-License-Identifier: MIT
"""Simulated boards with an IMU of known errors, put on their sides and turned about by hand: what a
calibration of each leaves.

raw = K true + offset + noise, every error at the datasheet's limit with a sign by chance (MPU-6050,
PS-MPU-6000A-00 rev 3.4, pp. 12, 13). What can be known of K is a triangle L and a turn Q of the
whole sensor against the board, inv(K) = Q L: gravity's length tells L, and nothing tells Q.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from terazi.applications.attitude.calibrated import PLACES, nothing_set, setting_names
from terazi.applications.attitude.records import Record
from terazi.calibration.imu.fit import MotionResult, fit_motion
from terazi.calibration.imu.standstill import find
from terazi.units import ACC_COUNTS_PER_STANDARD_GRAVITY as ONE_G
from terazi.units import GYRO_COUNTS_PER_DEG_S as GYRO_COUNTS

OFFSET_G, SCALE, CROSS, BIAS_DEG_S = 0.08, 0.03, 0.02, 20.0
BANDWIDTH_HZ = 98 * np.pi / 2  # of noise, behind a low-pass of first order at 98 Hz
ACC_NOISE_G, GYRO_NOISE_DEG_S = 400e-6 * BANDWIDTH_HZ**0.5, 0.005 * BANDWIDTH_HZ**0.5
TILT_DEG = 3.0  # by which a hand or a box puts a board amiss
STILL_S, TURN_S = 3.0, 2.0
BUMP_G = 0.2  # while it is turned
FACES = [(0, 0, 1), (0, 0, -1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)]
SLANTS = [(1, 1, 0), (1, -1, 0), (0, 1, 1), (0, 1, -1), (1, 0, 1), (-1, 0, 1)]


def unit(vector) -> np.ndarray:
    """Of length 1."""
    return np.asarray(vector, np.float64) / np.linalg.norm(vector)


def turn(vector_rad) -> np.ndarray:
    """(3, 3) of a rotation vector (Rodrigues)."""
    angle = np.linalg.norm(vector_rad)
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = np.asarray(vector_rad) / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


class Board:
    """One board; the seed says which way each of its errors goes."""

    def __init__(
        self,
        seed: int = 1,
        *,
        rate_hz: float = 250.0,
        offset_g: float = OFFSET_G,
        bias_deg_s: float = BIAS_DEG_S,
    ) -> None:
        self.rng = np.random.default_rng(seed)
        self.rate_hz = rate_hz
        self.acc_k, self.gyro_k = self._matrix(), self._matrix()
        self.acc_offset_g = offset_g * self._signs()
        self.bias_deg_s = bias_deg_s * self._signs()

    def _signs(self) -> np.ndarray:
        return self.rng.choice([-1.0, 1.0], 3)

    def _matrix(self) -> np.ndarray:
        signs = self.rng.choice([-1.0, 1.0], (3, 3))
        return np.eye(3) + signs * (np.eye(3) * SCALE + (1 - np.eye(3)) * CROSS)

    @property
    def truth(self) -> tuple[np.ndarray, np.ndarray]:
        """L, the accelerometer's matrix, and Q: by QR, with columns and rows in reverse."""
        flip = np.eye(3)[::-1]
        q, r = np.linalg.qr(np.linalg.inv(self.acc_k) @ flip)
        q, low = q @ flip, flip @ r @ flip
        signs = np.diag(np.sign(np.diag(low)))
        return signs @ low, q @ signs

    @property
    def gyro_truth(self) -> np.ndarray:
        """The gyroscope's matrix, into the axes of the calibrated accelerometer."""
        return self.truth[1].T @ np.linalg.inv(self.gyro_k)

    def sitting(self, ups: Sequence, *, tilt_deg: float = TILT_DEG) -> Record:
        """Lying with each of `ups`, in body axes, up in turn, and turned by hand between."""
        attitudes, rates, shocks = [], [], []
        now = self._attitude(ups[0], tilt_deg)
        for at in range(len(ups)):
            count = round(STILL_S * self.rate_hz)
            attitudes += [now] * count
            rates += [np.zeros(3)] * count
            shocks += [np.zeros(3)] * count
            if at + 1 == len(ups):
                break
            last = self._attitude(ups[at + 1], tilt_deg)
            middle = now @ turn(self.rng.normal(0, 0.6, 3))
            for begin, end in ((now, middle), (middle, last)):
                more = self._turned(begin, end, TURN_S / 2)
                attitudes += [a for a, _r in more]
                rates += [r for _a, r in more]
                shocks += list(self.rng.normal(0, BUMP_G, (len(more), 3)))
            now = last
        ups_b = np.array([a.T @ (0, 0, 1.0) for a in attitudes])
        return self.record(ups_b + np.array(shocks), np.array(rates))

    def _attitude(self, up, tilt_deg: float) -> np.ndarray:
        """Body to world, with `up` nearly up and any heading."""
        up = unit(unit(up) + np.radians(tilt_deg) / np.sqrt(2) * self.rng.normal(size=3))
        level = unit(np.cross(up, unit(self.rng.normal(size=3))))
        return np.array([level, np.cross(up, level), up])

    def _turned(self, begin: np.ndarray, end: np.ndarray, seconds: float) -> list[tuple]:
        """(attitude, rate in rad/s) of one smooth turn about one axis, sample by sample."""
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

    def record(self, acc_g: np.ndarray, rates_rad_s: np.ndarray) -> Record:
        """Raw counts of what the board feels, (n, 3) each in its own axes."""
        n = len(acc_g)
        acc = acc_g @ self.acc_k.T + self.acc_offset_g
        acc += self.rng.normal(0, ACC_NOISE_G, (n, 3))
        gyro = np.degrees(rates_rad_s) @ self.gyro_k.T + self.bias_deg_s
        gyro += self.rng.normal(0, GYRO_NOISE_DEG_S, (n, 3))
        sensors = counts(gyro * GYRO_COUNTS), counts(acc * ONE_G)
        return Record("simulated", self.rate_hz, np.arange(n), 1, *sensors)


def counts(values: np.ndarray) -> np.ndarray:
    """As the part's converter has them."""
    return np.clip(np.rint(values), -32768, 32767).astype(np.int16)


@dataclass(frozen=True)
class Left:
    """What a calibration leaves of one board's errors, by the settings that the device holds."""

    seed: int
    offset_mg: float  # the worst axis
    scale_percent: float
    cross_percent: float
    gyro_percent: float  # the worst element of its matrix
    bias_deg_s: float
    before_mg: float  # gravity off, rms over the positions
    after_mg: float


def held(group: str, settings: Mapping[str, int]) -> tuple[np.ndarray, np.ndarray]:
    """(M, offset in raw counts) of settings as they stand."""
    *matrix_q16, x, y, z = (settings[name] for name in setting_names(group))
    matrix = np.eye(3)
    for place, value in zip(PLACES[group], matrix_q16, strict=True):
        matrix[place] += value / 65536
    return matrix, np.linalg.solve(matrix, np.array((x, y, z)) / 8)


def left_of(board: Board, result: MotionResult, seed: int) -> Left:
    """Beside the truth."""
    matrix, offset = held("acc", result.settings)
    gyro, bias = held("gyro", result.settings)
    low, _turned = board.truth
    cross = (matrix - low)[~np.eye(3, dtype=bool)]
    return Left(
        seed=seed,
        offset_mg=float(np.abs(offset / ONE_G - board.acc_offset_g).max() * 1000),
        scale_percent=float(np.abs(np.diag(matrix) / np.diag(low) - 1).max() * 100),
        cross_percent=float(np.abs(cross).max() * 100),
        gyro_percent=float(np.abs(gyro - board.gyro_truth).max() * 100),
        bias_deg_s=float(np.abs(bias / GYRO_COUNTS - board.bias_deg_s).max()),
        before_mg=result.rms_g("before_g") * 1000,
        after_mg=result.rms_g("after_g") * 1000,
    )


def rehearse(seed: int) -> Left:
    """Calibrate one board on its six faces and six slants."""
    board = Board(seed)
    record = board.sitting([*FACES, *SLANTS])
    stills = find(record.acc_b_counts, record.gyro_b_counts, record.rate_hz)
    before = nothing_set("acc") | nothing_set("gyro")
    return left_of(board, fit_motion(record, stills, before), seed)


def worst(boards: Sequence[Left]) -> dict[str, float]:
    """The largest of each figure."""
    rows = [asdict(one) for one in boards]
    return {name: max(row[name] for row in rows) for name in rows[0] if name != "seed"}
