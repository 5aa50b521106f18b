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
RAMP_BLOCK = 16
MAG_BLOCK = 8


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


def upright(vector_w):
    """The shortest turn of the world that brings a vector to its vertical."""
    x, y, up = vector_w / np.linalg.norm(vector_w)
    if up >= 0:
        larger = math.sqrt((1 + up) / 2)
        return np.array([larger, y / (2 * larger), -x / (2 * larger), 0.0])
    larger = math.sqrt((1 - up) / 2)
    return np.array([y / (2 * larger), larger, 0.0, x / (2 * larger)])


class Mahony:
    """Float64 truth for ``mahony_update`` and ``mahony_update_mag``.

    config : fields of mahony_config_t (terazi.design.mahony). Quantised constants, the ramp's and
        the limits are taken as they are, so that only arithmetic differs; notes/mahony.md bounds
        that.
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
        self.ramp_left = self.correct_ramp = 0
        self.started = False
        self.smooth = self.reference = self.candidate = None
        self.settling = config["mag_settle_len"]
        self.undisturbed = self.accepted = 0
        self.rejected = self.phase = self.heading_gain = 0
        self.field_level = self.up = self.east = self.north = 0.0
        self.measured = None
        self.sums, self.whole, self.refused = np.zeros(2), False, False

    def _raised(self, name: str, most: int, ramp_left: int) -> int:
        more_q8 = ramp_left * self.config["ramp_step_q12"] // 16
        return min(most, self.config[name] + self.config[name] * more_q8 // 256)

    def update(self, gyro_counts, acc_counts, bias_counts=(0.0, 0.0, 0.0)) -> np.ndarray:
        """One sample of (3,) counts each; gives quat_wb (4,)."""
        gyro, acc = np.asarray(gyro_counts, float), np.asarray(acc_counts, float)
        if self.started:
            self._update(gyro, acc, np.asarray(bias_counts, float))
        elif acc.any():
            self.quat = product(upright(rotation(self.quat) @ acc), self.quat)
            self.mean[:], self.level = 0.0, 0.0
            self.ramp_left = self.correct_ramp = self.config["ramp_len"]
            self.sample += 1
            self.started = True
        if self.sample % RAMP_BLOCK == 0 and self.ramp_left:
            self.ramp_left -= 1
        if self.sample % RAMP_BLOCK == RAMP_BLOCK // 2:
            self.correct_ramp = self.ramp_left
        return self.quat

    def _update(self, gyro, acc, bias) -> None:
        config, matrix = self.config, rotation(self.quat)
        if config["integral"]:
            about = matrix[(self.sample + 1) % 2]
            self.integral -= about * self.correct * 2**19 * config["integral"] / 2**24
            self.integral = np.clip(self.integral, -INTEGRAL_MAX, INTEGRAL_MAX)
        self.sample += 1
        axis = self.sample % 2
        if acc.any():
            self._average(axis, matrix @ acc, acc)
            self.level = matrix[1 - axis] @ acc
        else:
            self.correct, self.level = 0.0, self.mean[1 - axis]
        self.rate = np.clip(gyro - bias - self.integral, -32768, 32767)
        half = self.rate * config["gyro_q33"] / 2**33
        self.quat = product(self.quat, turned(half + self.correct * matrix[1 - axis]))
        for _ in range(config["steps"] - 1):
            self.quat = product(self.quat, turned(half))
        self.quat = self.quat / np.linalg.norm(self.quat)

    def _average(self, axis, acc_w, acc) -> None:
        config = self.config
        if config["mode"] == SECOND_ORDER:
            gain = self._raised("lowpass_q16", 32767, self.ramp_left) / 65536
            self.mean[axis] += gain * (self.level + acc_w[axis] - 2 * self.mean[axis])
        elif config["mode"] == LINEAR:
            self.mean[axis] = (self.level + acc_w[axis]) / 2
        else:
            self.mean[axis] = 2048 * acc_w[axis] / np.linalg.norm(acc)
        self.mean[axis] = min(max(self.mean[axis], -MEAN_MAX), MEAN_MAX)
        gain = self._raised("correct_q18", 4095, self.correct_ramp) / 2**18
        turn = self.mean[axis] / 2048 * gain
        self.correct = min(max(turn if axis else -turn, CORRECT_MIN), CORRECT_MAX)

    def gap(self, samples: int) -> None:
        """So many samples are missing before the next one."""
        if samples > self.config["gap_max"]:
            self.started = False
        elif self.started:
            half = self.rate * self.config["gyro_q33"] / 2**33
            for _ in range(samples * self.config["steps"]):
                self.quat = product(self.quat, turned(half))
            self.level = self.mean[(self.sample + 1) % 2]

    def update_mag(self, mag_counts) -> np.ndarray:
        """One field, (3,) counts; gives quat_wb (4,)."""
        if not self.started:
            return self.quat
        field_w = rotation(self.quat) @ np.asarray(mag_counts, float)
        if self.smooth is None:
            self._start_heading(field_w)
            return self.quat
        if self.whole:
            self._work(field_w[2])
        self.sums += field_w[:2]
        self.phase = (self.phase + 1) % MAG_BLOCK
        self.whole = self.whole or self.phase == 0
        return self.quat

    def _start_heading(self, field_w) -> None:
        self.field_level, self.up = math.hypot(*field_w[:2]), field_w[2]
        self._measure()
        if self.refused:
            return
        half = math.atan2(field_w[0], field_w[1]) / 2
        self.quat = product([math.cos(half), 0, 0, math.sin(half)], self.quat)
        self.smooth = self.reference = self.candidate = self.measured
        self.sample += 1

    def _work(self, up: float) -> None:
        """The order of the C, which does an eighth of it in each sample."""
        if self.phase == 0:
            self.east, self.north = self.sums / MAG_BLOCK
            self.field_level, self.sums = math.hypot(self.east, self.north), np.zeros(2)
        elif self.phase == 1:
            self.up = up
        elif self.phase == 2:
            self._measure()
        elif self.phase == 3 and not self.refused:
            gain = self._mag_gain("mag_smooth_q16")
            self.smooth = self.smooth + gain * (self.measured - self.smooth)
        elif self.phase == 4:
            self._judge_reference()
        elif self.phase == 5:
            self._judge_candidate()
        elif self.phase == 6:
            self._decide()
        elif self.phase == 7 and not self.refused:
            sine = (
                self.east / self.field_level if self.north >= 0 else math.copysign(1.0, self.east)
            )
            turn = sine * self.heading_gain / 2**21
            self.quat = product([1.0, 0.0, 0.0, turn], self.quat)
            self.quat = self.quat / np.linalg.norm(self.quat)

    def _measure(self) -> None:
        norm = math.hypot(self.field_level, self.up)
        self.refused = 16 * self.field_level <= norm
        if not self.refused:
            self.measured = np.array([norm, self.up / norm])

    def _mag_gain(self, name: str) -> float:
        return self.config[name] / 65536

    def _near(self, other) -> bool:
        norm_off, dip_off = np.abs(self.smooth - other)
        return norm_off < other[0] / 10 and dip_off < 0.17

    def _judge_reference(self) -> None:
        if self._near(self.reference):
            self.undisturbed += 1
            learn = self._mag_gain("mag_learn_q16")
            self.reference = self.reference + learn * (self.smooth - self.reference)
        else:
            self.undisturbed = 0

    def _judge_candidate(self) -> None:
        if self._near(self.candidate):
            self.accepted += int(np.abs(self.rate).max() > self.config["moving_min"])
            learn = self._mag_gain("mag_learn_q16")
            self.candidate = self.candidate + learn * (self.smooth - self.candidate)
        else:
            self.accepted, self.candidate = 0, self.smooth

    def _disturbed(self) -> bool:
        config = self.config
        if self.settling:
            self.settling -= 1
            return False
        if self.undisturbed >= config["mag_recover_len"]:
            return False
        if self.accepted <= config["mag_accept_len"]:
            return True
        self.reference = self.candidate
        self.undisturbed, self.accepted = config["mag_recover_len"], 0
        return False

    def _decide(self) -> None:
        self.heading_gain = self._raised("mag_correct_q21", 16383, self.ramp_left)
        if not self._disturbed():
            self.rejected = max(0, self.rejected - 2)
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
