# SPDX-License-Identifier: MIT
"""Float64 truth for mahony.c: exact rotations, real numbers, no carries."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

SECOND_ORDER, LINEAR, CLASSIC = range(3)
CORRECT_MIN, CORRECT_MAX = -512 / 2**19, 511 / 2**19
MEAN_MAX = 2.0**13  # counts: 2^27 in Q14
INTEGRAL_MAX = 328.0
START_LEN, RAMP_LEN = 3, 12
RATE_MAX = 32000
MAG_BLOCK = 8
HEADING_MAX = 14000


def product(p, q):
    """Quaternion product, scalar first."""
    (a, b, c, d), (w, x, y, z) = p, q
    return np.array(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )


def rotation(quat_wb):
    """(3, 3) matrix that takes body vectors to world."""
    w, x, y, z = quat_wb
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def turned(half_angles):
    """Quaternion of a rotation by twice this vector, exactly."""
    half = math.sqrt(float(half_angles @ half_angles))
    return np.concatenate([[math.cos(half)], half_angles * np.sinc(half / math.pi)])


def euler(quat_wb):
    """Roll, pitch and yaw in rad, order z-y-x."""
    matrix = rotation(quat_wb)
    return (
        math.atan2(matrix[2, 1], matrix[2, 2]),
        math.asin(min(1.0, max(-1.0, -matrix[2, 0]))),
        math.atan2(matrix[1, 0], matrix[0, 0]),
    )


class Mahony:
    """Float64 truth for ``mahony_modes_update`` and ``mahony_update_mag``.

    config : fields of mahony_modes_config_t, flat (terazi.design.mahony). Quantised constants, the
        ramp's and the limits are taken as they are, so that only arithmetic differs;
        notes/mahony.md bounds that.
    """

    def __init__(self, config: Mapping[str, int]) -> None:
        self.config = config
        self.quat = np.array([1.0, 0.0, 0.0, 0.0])
        self.rate = np.zeros(3)
        self.level = 0.0
        self.mean = np.zeros(2)
        self.correct = 0.0
        self.sample = 0
        self.integral = np.zeros(3)
        self.ramp_left = START_LEN + RAMP_LEN
        self.reference = self.candidate = np.zeros(2)
        self.undisturbed = self.accepted = self.rejected = 0
        self.phase = self.raised = self.heading_gain = 0
        self.field_level = self.up = self.east = self.north = 0.0
        self.sums, self.whole, self.refused = np.zeros(2), False, True

    @property
    def starting(self) -> bool:
        """Acceleration stands the estimate upright at once."""
        return self.ramp_left > RAMP_LEN

    def _raised(self, name: str, most: int) -> int:
        times = 0 if self.starting else 2 ** math.ceil(3 * self.ramp_left / RAMP_LEN)
        return min(most, self.config[name] * times)

    def update(self, gyro_counts, acc_counts, bias_counts=(0.0, 0.0, 0.0)) -> np.ndarray:
        """One sample of (3,) counts each; gives quat_wb (4,)."""
        gyro, acc = np.asarray(gyro_counts, float), np.asarray(acc_counts, float)
        config, matrix = self.config, rotation(self.quat)
        if config["integral"] and not self.starting:
            about = matrix[(self.sample + 1) % 2]
            self.integral -= about * self.correct * 2**19 * config["integral"] / 2**24
            self.integral = np.clip(self.integral, -INTEGRAL_MAX, INTEGRAL_MAX)
        self.sample += 1
        axis = self.sample % 2
        if self.starting:
            turn = (self.level if axis else -self.level) * 2.0 ** (14 - config["start_shift"])
            gyro = gyro + np.clip(turn, -RATE_MAX, RATE_MAX) * matrix[1 - axis]
            gyro = np.clip(gyro, -32768, 32767)
        self.correct = 0.0
        if acc.any():
            self._average(axis, matrix @ acc, acc)
        self.level = matrix[1 - axis] @ acc
        bias = np.asarray(bias_counts, float) + self.integral
        self.rate = np.clip(gyro - bias, -32768, 32767)
        half = self.rate * config["gyro_q33"] / 2**33
        self.quat = product(self.quat, turned(half + self.correct * matrix[1 - axis]))
        for _ in range(config["steps"] - 1):
            self.quat = product(self.quat, turned(half))
        self.quat = self.quat / np.linalg.norm(self.quat)
        if self.ramp_left and self.sample & config["ramp_mask"] == 0:
            self.ramp_left -= 1
        return self.quat

    def _average(self, axis, acc_w, acc) -> None:
        config = self.config
        if config["mode"] == SECOND_ORDER:
            gain = self._raised("lowpass_q16", 32767) / 65536
            self.mean[axis] += gain * (self.level + acc_w[axis] - 2 * self.mean[axis])
        elif self.starting:
            pass
        elif config["mode"] == LINEAR:
            self.mean[axis] = (self.level + acc_w[axis]) / 2
        else:
            self.mean[axis] = 2048 * acc_w[axis] / np.linalg.norm(acc)
        self.mean[axis] = min(max(self.mean[axis], -MEAN_MAX), MEAN_MAX)
        gain = self._raised("correct_q18", 4095) / 2**18
        turn = self.mean[axis] / 2048 * gain
        self.correct = min(max(turn if axis else -turn, CORRECT_MIN), CORRECT_MAX)

    def gap(self, samples: int) -> None:
        """So many samples are missing before the next one."""
        if samples > self.config["gap_max"]:
            self.ramp_left, self.mean = START_LEN + RAMP_LEN, np.zeros(2)
        elif not self.starting:
            half = self.rate * self.config["gyro_q33"] / 2**33
            for _ in range(samples * self.config["steps"]):
                self.quat = product(self.quat, turned(half))
            self.sample += samples
            self.level = 0.0

    def update_mag(self, mag_counts) -> np.ndarray:
        """One field, (3,) counts; gives quat_wb (4,)."""
        if self.starting:
            self.raised = 0
        field_w = rotation(self.quat) @ np.asarray(mag_counts, float)
        if self.whole:
            self._work()
        self.sums += field_w[:2]
        self.phase = (self.phase + 1) % MAG_BLOCK
        if self.phase == 4:
            self.up = field_w[2]
        self.whole = self.whole or self.phase == 0
        return self.quat

    def _work(self) -> None:
        """The order of the C, which does a part of it in each sample."""
        if self.phase == 0:
            self.east, self.north = self.sums / MAG_BLOCK
            self.field_level, self.sums = math.hypot(self.east, self.north), np.zeros(2)
            self.refused = 16 * self.field_level <= abs(self.up)
        elif self.refused:
            return
        elif self.phase == 1:
            self._judge_reference()
        elif self.phase == 2:
            self._judge_candidate()
            self._decide()
        elif self.phase > 3:
            sine = (
                self.east / self.field_level if self.north >= 0 else math.copysign(1.0, self.east)
            )
            turn = sine * self.heading_gain / 2**21
            self.quat = product([1.0, 0.0, 0.0, turn], self.quat)
            self.quat = self.quat / np.linalg.norm(self.quat)

    def _agrees(self, other):
        """What `other`, level and up, becomes by the field; None where that is another."""
        off = np.array([self.field_level, self.up]) - other
        if np.abs(off).sum() >= np.abs(other).sum() / 8:
            return None
        return other + self.config["mag_learn_q16"] / 65536 * off

    def _judge_reference(self) -> None:
        followed = self._agrees(self.reference)
        if followed is None:
            self.undisturbed = 1
        else:
            self.undisturbed += 1
            self.reference = followed

    def _judge_candidate(self) -> None:
        followed = self._agrees(self.candidate)
        if followed is None:
            self.accepted, followed = 0, np.array([self.field_level, self.up])
        else:
            self.accepted += int(np.abs(self.rate).max() > self.config["moving_min"])
        self.candidate = followed

    def _disturbed(self) -> bool:
        if self.undisturbed > self.config["mag_recover_len"]:
            return False
        if self.accepted <= self.config["mag_accept_len"] and self.raised:
            return True
        self.reference, self.undisturbed, self.accepted = self.candidate, 65535, 0
        return False

    def _decide(self) -> None:
        disturbed = self._disturbed()
        high = self.raised - self.raised // 256 - 1 if self.raised else HEADING_MAX
        self.raised = self.heading_gain = max(self.config["mag_correct_q21"], high)
        if not disturbed:
            self.rejected = max(0, self.rejected - 1)
        elif self.rejected >= self.config["mag_reject_len"]:
            self.heading_gain //= 2
        else:
            self.rejected += 1
            self.heading_gain = 0


def run(gyro_counts, acc_counts, config, *, bias_counts=None, mag_counts=None):
    """(n, 4) quat_wb after each of (n, 3) samples; with mag_counts in 9 axes."""
    filter_ = Mahony(config)
    quats = np.empty((len(gyro_counts), 4))
    for n, (gyro, acc) in enumerate(zip(gyro_counts, acc_counts, strict=True)):
        bias = (0.0, 0.0, 0.0) if bias_counts is None else bias_counts[n]
        quats[n] = filter_.update(gyro, acc, bias)
        if mag_counts is not None:
            quats[n] = filter_.update_mag(mag_counts[n])
    return quats


def errors_deg(quats, truths):
    """(n,) inclination and (n,) total angle between two runs, deg."""
    quats, truths = np.asarray(quats, float), np.asarray(truths, float)
    (a, b, c, d), (w, x, y, z) = quats.T, (truths * [1, -1, -1, -1]).T
    # From the vector part of the difference: its scalar part has no digits left for small angles.
    w, x, y, z = product((a, b, c, d), (w, x, y, z))
    inclination = 2 * np.arctan2(np.hypot(x, y), np.hypot(w, z))
    total = 2 * np.arctan2(np.sqrt(x**2 + y**2 + z**2), np.abs(w))
    return np.degrees(inclination), np.degrees(total)
