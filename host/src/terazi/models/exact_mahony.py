# SPDX-License-Identifier: MIT
"""Twin of mahony.h and port_turn.h in Python's unbounded integers, from their contracts."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence

from terazi.models import exact_euler
from terazi.models.exact import COUNTER_MAX, rounded_shift

Vector = Sequence[int]
SECOND_ORDER, LINEAR, CLASSIC = range(3)
ONE_Q14 = 1 << 14
INTEGRAL_MAX_Q22 = 328 << 22
MEAN_END_Q14 = 1 << 27
RAMP_BLOCK = 16
COUNTS = ("acc_zero", "railed", "mag_refused", "mag_disturbed", "gaps")


def limit(value: int, end: int) -> int:
    """value in -end .. end - 1."""
    return min(max(value, -end), end - 1)


def int16(value: int) -> int:
    """value limited to 16 bits."""
    return limit(value, 1 << 15)


def dot(a: Vector, b: Vector) -> int:
    """Inner product."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a: Vector, b: Vector) -> list[int]:
    """Vector product."""
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def quaternion_product(p: Vector, q: Vector) -> list[int]:
    """p q, scalar first."""
    turned = cross(p[1:], q[1:])
    vector = [p[0] * q[i + 1] + q[0] * p[i + 1] + turned[i] for i in range(3)]
    return [p[0] * q[0] - dot(p[1:], q[1:]), *vector]


class Carries:
    """Remainders that wait for the next sample, by name."""

    def __init__(self) -> None:
        self.kept: dict[object, int] = {}

    def __call__(self, key: object, value: int, bits: int = 16) -> int:
        total = value + self.kept.get(key, 0)
        self.kept[key] = total % (1 << bits)
        return total >> bits


class Root:
    """mahony_internal.h's inverse square root: value 4^shift = m 2^32, 1/4 <= m < 1."""

    def __init__(self, value: int) -> None:
        self.shift = (32 - value.bit_length()) // 2
        scaled = value << 2 * self.shift
        self.m_q16 = scaled >> 16
        place = scaled >> 24
        first_q7 = min(255, math.floor(128 / math.sqrt((place + 0.5) / 256) + 0.5))
        factor_q14 = (3 * 2**30 - self.m_q16 * first_q7**2) >> 16
        self.inverse_q15 = min(65535, first_q7 * factor_q14 >> 7)

    def unit_q14(self, component: int) -> int:
        """component / sqrt(value)."""
        return rounded_shift(component * self.inverse_q15, 17 - self.shift)

    def length(self) -> int:
        """sqrt(value)."""
        return self.m_q16 * self.inverse_q15 >> 15 + self.shift


def normalised(quat_q30: Vector) -> list[int]:
    """Norm 1 within 1e-6, of a norm within 2^-9 of 1."""
    high = [rounded_shift(value, 16) for value in quat_q30]
    rest = [(value - (h << 16)) >> 8 for value, h in zip(quat_q30, high, strict=True)]
    error_q28 = sum(h * h + (h * r >> 7) for h, r in zip(high, rest, strict=True)) - 2**28
    half = rounded_shift(error_q28, 5)
    square = half * half >> 24
    factor = square + (square >> 1) - half
    return [value + rounded_shift(h * factor, 8) for value, h in zip(quat_q30, high, strict=True)]


def half_turn_q14(cosine: int, sines: Vector) -> tuple[list[int], bool]:
    """Larger one of cosine and sine of half an angle, then `sines` / (2 larger); whether the larger
    one is the cosine."""
    half_q32 = min(2**32 - 1, abs(cosine) + ONE_Q14 << 17)
    root = Root(half_q32)
    larger = rounded_shift((half_q32 >> 16) * root.inverse_q15, 17)
    inverse_q14 = root.inverse_q15 >> 1
    return [larger, *(rounded_shift(sine * inverse_q14, 15) for sine in sines)], cosine >= 0


class Mahony:
    """mahony_t and its functions. config: the fields of mahony_config_t."""

    def __init__(self, config: Mapping[str, int]) -> None:
        self.config = dict(config)
        self.quat_q30 = [1 << 30, 0, 0, 0]
        self.quat_q14 = [ONE_Q14, 0, 0, 0]
        self.rows = [[ONE_Q14, 0, 0], [0, ONE_Q14, 0]]
        self.norm_error_q20 = 0
        self.rate = [0, 0, 0]
        self.level = 0
        self.mean = [0, 0]
        self.correct = 0
        self.sample = 0
        self.integral = [0, 0, 0]
        self.ramp_left = 0
        self.started = False
        self.carry = Carries()
        for i in range(3):
            self.carry.kept["rate", i] = self.carry.kept["turn", i] = 1 << 15
        self.cut = [128] * 4
        self.counts = dict.fromkeys(COUNTS, 0)
        self.field = None
        self.settling = self.config["mag_settle_len"]
        self.undisturbed = self.accepted = self.rejected = 0

    def copy(self) -> Mahony:
        """Another one in the same state."""
        return copy.deepcopy(self)

    def _count(self, name: str) -> None:
        self.counts[name] = min(self.counts[name] + 1, COUNTER_MAX)

    def _raised(self, gain: int) -> int:
        more_q8 = self.ramp_left * self.config["ramp_step_q12"] >> 4
        return min(32767, gain + (gain * more_q8 >> 8))

    # One step, in the order of port_turn.h

    def _step(self, gyro: Vector, acc: Vector, bias_q16: Vector) -> None:
        self.sample = (self.sample + 1) % 256
        axis = self.sample % 2
        if any(acc):
            self._average(axis, dot(self.rows[axis], acc))
        else:
            self.correct = 0
        self.level = dot(self.rows[1 - axis], acc)
        self.rate = [
            int16(self.carry(("rate", i), 65536 * gyro[i] - bias_q16[i])) for i in range(3)
        ]
        self._turn(self.rows[1 - axis])
        self._rows()

    def _average(self, axis: int, level: int) -> None:
        diff = self.carry(("mean", axis), self.level + level - 2 * self.mean[axis])
        self.mean[axis] = limit(self.mean[axis] + diff * self.lowpass, MEAN_END_Q14)
        turn = (self.mean[axis] >> 8) * self.correct_gain
        self.correct = limit(self.carry(("correct", axis), turn if axis else -turn), 512)

    def _turn(self, about: Vector) -> None:
        square = self.carry("square", dot(self.rate, self.rate))
        loss = self.carry("loss", square * self.config["square"] + 512 * self.norm_error_q20)
        scale = self.carry("scale", 65536 * self.config["gyro_q33"] - loss * self.config["cubic"])
        half_angles = [
            self.carry(("turn", i), scale * self.rate[i] + self.correct * about[i])
            for i in range(3)
        ]
        product = quaternion_product(self.quat_q14, [-loss, *half_angles])
        for i in range(4):
            self.quat_q30[i] += rounded_shift(product[i], 1)
            total = (self.quat_q30[i] >> 8) + self.cut[i]
            self.quat_q14[i], self.cut[i] = total >> 8, total % 256

    def _rows(self) -> None:
        w, x, y, z = self.quat_q14

        def entry(value_q28: int) -> int:
            return rounded_shift(value_q28 >> 8, 6)

        def half(half_q28: int) -> int:
            return rounded_shift(half_q28 >> 8, 5)

        self.rows = [
            [entry(w * w + x * x - y * y - z * z), half(x * y - w * z), half(x * z + w * y)],
            [half(x * y + w * z), entry(w * w - x * x + y * y - z * z), half(y * z - w * x)],
        ]
        self.norm_error_q20 = dot(self.quat_q14, self.quat_q14) - 2**28 >> 8

    def _still(self) -> None:
        self.norm_error_q20, rate = 0, self.rate
        self._step((0, 0, 0), (0, 0, 0), (0, 0, 0))
        self.rate = rate

    # What is around it, in the order of mahony.c

    @property
    def lowpass(self) -> int:
        """lp dt, Q16, as the ramp has it."""
        return self._gains[0]

    @property
    def correct_gain(self) -> int:
        """kp dt, Q18, as the ramp has it."""
        return self._gains[1]

    _gains = (0, 0)

    def _set_gains(self) -> None:
        names = ("lowpass_q16", "correct_q18")
        lowpass, correct = (self._raised(self.config[name]) for name in names)
        self._gains = lowpass, min(4095, correct)

    def _forget_level(self) -> None:
        self.level = self.mean[(self.sample + 1) % 2]

    def up(self) -> list[int]:
        """Third row of the rotation matrix."""
        return [rounded_shift(value, 14) for value in cross(*self.rows)]

    def to_world(self, vector: Vector) -> list[int]:
        """A body vector in world axes."""
        return [int16(rounded_shift(dot(row, vector), 14)) for row in (*self.rows, self.up())]

    def free_acceleration(self, acc: Vector) -> list[int]:
        """acc less gravity, body axes."""
        one_g = self.config["acc_one_g"]
        gravity = [rounded_shift(value * one_g, 14) for value in self.up()]
        return [int16(a - g) for a, g in zip(acc, gravity, strict=True)]

    def _turn_world(self, left_q14: Vector) -> None:
        right = [rounded_shift(value, 16) for value in self.quat_q30]
        self.quat_q30 = normalised([4 * v for v in quaternion_product(left_q14, right)])
        self.cut = [128] * 4
        self._still()

    def _start(self, acc: Vector) -> None:
        acc_w = self.to_world(acc)
        if not any(acc_w):
            return
        root = Root(dot(acc_w, acc_w))
        x, y, up = (root.unit_q14(value) for value in acc_w)
        (larger, sine_x, sine_y), upright = half_turn_q14(up, (x, y))
        self._turn_world((larger, sine_y, -sine_x, 0) if upright else (sine_y, larger, 0, sine_x))
        self.mean = [0, 0]
        for axis in range(2):
            self.carry.kept["mean", axis] = self.carry.kept["correct", axis] = 0
        self.level = 0
        self.ramp_left = self.config["ramp_len"]
        self._set_gains()
        self.started = True

    def _integrate(self) -> None:
        about = self.rows[(self.sample + 1) % 2]
        more = self.carry("integral", self.correct * self.config["integral"])
        for i in range(3):
            bias = self.integral[i] - about[i] * more
            self.integral[i] = min(max(bias, -INTEGRAL_MAX_Q22), INTEGRAL_MAX_Q22)

    def _follow(self, acc: Vector) -> None:
        axis = (self.sample + 1) % 2
        level = dot(self.rows[axis], acc)
        if self.config["mode"] == LINEAR:
            self.mean[axis] = limit(level + self.level >> 1, MEAN_END_Q14)
        else:
            root = Root(dot(acc, acc))
            self.mean[axis] = root.unit_q14(int16(rounded_shift(level, 14))) * 2048

    def update(self, gyro: Vector, acc: Vector, bias_q16: Vector = (0, 0, 0)) -> None:
        """mahony_update."""
        if not self.started:
            if any(acc):
                self._start(acc)
            else:
                self._count("acc_zero")
        else:
            self._update(gyro, acc, bias_q16)
        if self.sample % RAMP_BLOCK == 0 and self.ramp_left:
            self.ramp_left -= 1
            self._set_gains()

    def _update(self, gyro: Vector, acc: Vector, bias_q16: Vector) -> None:
        if self.config["integral"]:
            self._integrate()
        both = [b + (i >> 6) for b, i in zip(bias_q16, self.integral, strict=True)]
        if self.config["mode"] != SECOND_ORDER and any(acc):
            self._follow(acc)
        self._step(gyro, acc, both)
        if any(value >> 8 in (127, -128) for value in (*gyro, *acc)):
            self._count("railed")
        if not any(acc):
            self._count("acc_zero")
            self._forget_level()
        self._repeat(self.config["steps"] - 1)

    def _repeat(self, steps: int) -> None:
        level, sample = self.level, self.sample
        for _ in range(steps):
            self._step(self.rate, (0, 0, 0), (0, 0, 0))
        self.level, self.sample = level, sample

    def gap(self, samples: int) -> None:
        """mahony_gap."""
        self._count("gaps")
        if samples > self.config["gap_max"]:
            self.started = False
        elif self.started:
            for _ in range(samples):
                self._repeat(self.config["steps"])
            self._forget_level()

    def quaternion(self) -> list[int]:
        """mahony_quaternion."""
        return normalised(self.quat_q30)

    # Magnetometer

    def _sample_field(self, mag: Vector):
        mag_w = self.to_world([int16(value << self.config["mag_shift"]) for value in mag])
        level2, norm2 = dot(mag_w[:2], mag_w[:2]), dot(mag_w, mag_w)
        if level2 <= norm2 >> 8:
            return None
        level, norm = Root(level2), Root(norm2)
        measured = (min(32767, norm.length()), int16(2 * norm.unit_q14(mag_w[2])))
        return measured, level.unit_q14(mag_w[0]), level.unit_q14(mag_w[1])

    def update_mag(self, mag: Vector) -> None:
        """mahony_update_mag."""
        if not self.started:
            return
        sampled = self._sample_field(mag)
        if sampled is None:
            self._count("mag_refused")
            return
        measured, east, north = sampled
        if self.field is None:
            (larger, smaller), ahead = half_turn_q14(north, (east,))
            self._turn_world((larger, 0, 0, smaller) if ahead else (smaller, 0, 0, larger))
            smooth = [value << 16 for value in measured]
            self.field = {"smooth": smooth, "reference": smooth[:], "candidate": smooth[:]}
            return
        self._learn("smooth", measured, self.config["mag_smooth_q16"])
        sine = east if north >= 0 else ONE_Q14 if east > 0 else -ONE_Q14
        turn = self.carry("heading", 4 * sine * self._heading_gain())
        k_quat = quaternion_product((0, 0, 0, 1), self.quat_q14)
        for i, part in enumerate(k_quat):
            self.quat_q30[i] += rounded_shift(part * turn, 8)

    def _learn(self, name: str, measured: Vector, gain: int) -> None:
        state = self.field[name]
        for i, target in enumerate(measured):
            state[i] += (target - (state[i] >> 16)) * gain

    def _near(self, name: str) -> bool:
        smooth, other = ([v >> 16 for v in self.field[key]] for key in ("smooth", name))
        norm_max = other[0] * 6554 >> 16
        return abs(smooth[0] - other[0]) < norm_max and abs(smooth[1] - other[1]) < 5571

    def _disturbed(self) -> bool:
        config = self.config
        smooth = [value >> 16 for value in self.field["smooth"]]
        if self._near("reference"):
            self.undisturbed = min(self.undisturbed + 1, COUNTER_MAX)
            self._learn("reference", smooth, config["mag_learn_q16"])
        else:
            self.undisturbed = 0
        if self._near("candidate"):
            if any(abs(rate) > config["moving_min"] for rate in self.rate):
                self.accepted = min(self.accepted + 1, COUNTER_MAX)
            self._learn("candidate", smooth, config["mag_learn_q16"])
        else:
            self.accepted = 0
            self.field["candidate"] = self.field["smooth"][:]
        if self.settling:
            self.settling -= 1
            return False
        if self.undisturbed >= config["mag_recover_len"]:
            return False
        if self.accepted <= config["mag_accept_len"]:
            return True
        self.field["reference"] = self.field["candidate"][:]
        self.undisturbed, self.accepted = config["mag_recover_len"], 0
        return False

    def _heading_gain(self) -> int:
        gain = min(16383, self._raised(self.config["mag_correct_q24"]))
        if not self._disturbed():
            self.rejected = max(0, self.rejected - 2)
            return gain
        self._count("mag_disturbed")
        if self.rejected >= self.config["mag_reject_len"]:
            return gain >> 1
        self.rejected += 1
        return 0

    def euler(self, held: list[int]) -> tuple[int, int, int]:
        """mahony_euler."""
        return exact_euler.euler(self.quat_q30, held)
