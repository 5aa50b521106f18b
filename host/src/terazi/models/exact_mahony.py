# SPDX-License-Identifier: MIT
"""Twin of mahony.h and port_turn.h in Python's unbounded integers, from their contracts."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping

from terazi.models import exact_euler
from terazi.models.exact import COUNTER_MAX, rounded_shift
from terazi.models.exact_vectors import (
    ONE_Q14,
    Carries,
    Vector,
    cross,
    dot,
    int16,
    limit,
    normalised,
    quaternion_product,
    ratio_q15,
    shift_14,
)

SECOND_ORDER, LINEAR, CLASSIC = range(3)
INTEGRAL_MAX_Q22 = 328 << 22
MEAN_END_Q14 = 1 << 27
START_LEN, RAMP_LEN = 3, 12
RATE_MAX = 32000
MAG_BLOCK = 8
PART_MAX = 23170
HEADING_MAX = 14000
COUNTS = ("acc_zero", "railed", "mag_refused", "mag_disturbed", "gaps")


class Mahony:
    """mahony_modes_t and its functions. config: the fields of mahony_modes_config_t, flat."""

    def __init__(self, config: Mapping[str, int]) -> None:
        self.config = dict(config)
        self.carry = Carries()
        self.quat_q30 = [1 << 30, 0, 0, 0]
        self.quat_q14 = [ONE_Q14, 0, 0, 0]
        self.rows = [[ONE_Q14, 0, 0], [0, ONE_Q14, 0]]
        self.norm_error_q20 = 0
        self.rate = [0, 0, 0]
        self.level = 0
        self.correct = 0
        self.sample = 0
        self.integral = [0, 0, 0]
        self._restart()
        self.cut = [0] * 4
        self.counts = dict.fromkeys(COUNTS, 0)
        self.reference = self.candidate = [0, 0]
        self.undisturbed = self.accepted = self.rejected = 0
        self.phase = self.field_level = self.raised = self.heading_gain = 0
        self.sums, self.field, self.whole = [0, 0], [0, 0], False

    def copy(self) -> Mahony:
        """Another one in the same state."""
        return copy.deepcopy(self)

    def _count(self, name: str) -> None:
        self.counts[name] = min(self.counts[name] + 1, COUNTER_MAX)

    def _restart(self) -> None:
        self.ramp_left = START_LEN + RAMP_LEN
        self.lowpass = self.correct_gain = 0
        self.mean = [0, 0]
        for axis in range(2):
            self.carry.kept["mean", axis] = self.carry.kept["correct", axis] = 0

    @property
    def starting(self) -> bool:
        """Acceleration stands the estimate upright at once."""
        return self.ramp_left > RAMP_LEN

    def _lower_ramp(self) -> None:
        self.ramp_left -= 1
        if not self.starting:
            times = 2 ** math.ceil(3 * self.ramp_left / RAMP_LEN)
            self.lowpass = self.config["lowpass_q16"] * times
            self.correct_gain = min(4095, self.config["correct_q18"] * times)

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

    # What is around it, in the order of mahony.c

    def up(self) -> list[int]:
        """Third row of the rotation matrix."""
        return [rounded_shift(value, 14) for value in cross(*self.rows)]

    def free_acceleration(self, acc: Vector) -> list[int]:
        """acc less gravity, body axes."""
        one_g = self.config["acc_one_g"]
        gravity = [shift_14(value * one_g) for value in self.up()]
        return [int16(a - g) for a, g in zip(acc, gravity, strict=True)]

    def _stand(self, gyro: Vector) -> list[int]:
        axis = (self.sample + 1) % 2
        level = self.level >> self.config["start_shift"]
        turn = min(max(level if axis else -level, -RATE_MAX), RATE_MAX) | 1
        pulls = [rounded_shift(turn * part, 14) for part in self.rows[1 - axis]]
        return [int16(rate + each) for rate, each in zip(gyro, pulls, strict=True)]

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
            self.mean[axis] = self._normalised(level, acc)

    @staticmethod
    def _normalised(level: int, acc: Vector) -> int:
        """level / |acc| in Q25."""
        halves = [value >> 1 for value in acc]
        square, shift = dot(halves, halves), 0
        if square < 1 << 22:
            square, shift = 16 * dot(acc, acc), 3
        length = math.isqrt(square)
        size = ratio_q15(min(length, abs(level) >> 15 - shift), length) << 10
        return -size if level < 0 else size

    def update(self, gyro: Vector, acc: Vector, bias_q16: Vector = (0, 0, 0)) -> None:
        """mahony_modes_update."""
        steps = self.config["steps"]
        if not self.starting and self.config["integral"]:
            self._integrate()
        both = [b + (i >> 6) for b, i in zip(bias_q16, self.integral, strict=True)]
        if self.starting:
            gyro = self._stand(gyro)
        elif self.config["mode"] != SECOND_ORDER and any(acc):
            self._follow(acc)
        self._step(gyro, acc, both)
        if any(value >> 8 in (127, -128) for value in (*gyro, *acc)):
            self._count("railed")
        if not any(acc):
            self._count("acc_zero")
        if self.ramp_left and self.sample & self.config["ramp_mask"] == 0:
            self._lower_ramp()
        self._repeat(steps - 1)

    def _repeat(self, steps: int) -> None:
        level, sample = self.level, self.sample
        for _ in range(steps):
            self._step(self.rate, (0, 0, 0), (0, 0, 0))
        self.level, self.sample = level, sample

    def gap(self, samples: int) -> None:
        """mahony_gap."""
        self._count("gaps")
        if samples > self.config["gap_max"]:
            self._restart()
        elif not self.starting:
            for _ in range(samples):
                self._repeat(self.config["steps"] - 1)
                self._step(self.rate, (0, 0, 0), (0, 0, 0))

    def quaternion(self) -> list[int]:
        """mahony_quaternion."""
        return normalised(self.quat_q30)

    # Magnetometer

    @staticmethod
    def _limited(part_q9: int) -> int:
        return min(max(part_q9 >> 8, -PART_MAX), PART_MAX)

    def update_mag(self, mag: Vector) -> None:
        """mahony_update_mag."""
        if self.starting:
            self.raised = 0
        if self.whole:
            self._work()
        self.sums = [s + (dot(row, mag) >> 8) for s, row in zip(self.sums, self.rows, strict=True)]
        self.phase = (self.phase + 1) % MAG_BLOCK
        if self.phase == 4:
            self.field[1] = self._limited((dot(self.up(), mag) >> 8) * 8) >> 1
        self.whole = self.whole or self.phase == 0

    def _work(self) -> None:
        if self.phase == 0:
            self._take_block()
        elif self.field_level:
            parts = (self._judge_reference, self._judge_candidate, int)
            (*parts, *[self._turn_heading] * 4)[self.phase - 1]()

    def _take_block(self) -> None:
        self.mean_field, self.sums = [self._limited(total) for total in self.sums], [0, 0]
        self.field_level = math.isqrt(dot(self.mean_field, self.mean_field))
        self.field[0] = self.field_level >> 1
        if self.field_level <= abs(self.field[1]) >> 3:
            self.field_level = 0
            self._count("mag_refused")

    def _agrees(self, other: list[int]) -> list[int] | None:
        """What `other`, level and up in Q16, becomes by the field; None where that is another."""
        parts = [value >> 16 for value in other]
        off = [now - part for now, part in zip(self.field, parts, strict=True)]
        if sum(map(abs, off)) >= sum(map(abs, parts)) >> 3:
            return None
        learn = self.config["mag_learn_q16"]
        return [value + each * learn for value, each in zip(other, off, strict=True)]

    def _judge_reference(self) -> None:
        followed = self._agrees(self.reference)
        self.undisturbed = min(self.undisturbed + 1, COUNTER_MAX) if followed else 1
        self.reference = followed or self.reference

    def _judge_candidate(self) -> None:
        followed = self._agrees(self.candidate)
        if not followed:
            self.accepted, followed = 0, [value << 16 for value in self.field]
        elif any(abs(rate) > self.config["moving_min"] for rate in self.rate):
            self.accepted = min(self.accepted + 1, COUNTER_MAX)
        self.candidate = followed
        self._decide()

    def _disturbed(self) -> bool:
        if self.undisturbed > self.config["mag_recover_len"]:
            return False
        if self.accepted <= self.config["mag_accept_len"] and self.raised:
            return True
        self.reference, self.undisturbed, self.accepted = self.candidate, COUNTER_MAX, 0
        return False

    def _decide(self) -> None:
        disturbed = self._disturbed()
        high = self.raised - (self.raised >> 8) - 1 if self.raised else HEADING_MAX
        self.raised = self.heading_gain = max(self.config["mag_correct_q21"], high)
        if not disturbed:
            self.rejected = max(0, self.rejected - 1)
            return
        self._count("mag_disturbed")
        if self.rejected >= self.config["mag_reject_len"]:
            self.heading_gain >>= 1
        else:
            self.rejected += 1
            self.heading_gain = 0

    def _turn_heading(self) -> None:
        (east, north), level = self.mean_field, self.field_level
        sine_q14 = ratio_q15(level if north < 0 else abs(east), level) >> 1
        turn = self.carry("heading", 4 * (-sine_q14 if east < 0 else sine_q14) * self.heading_gain)
        for i, sign in enumerate((-1, -1, 1, 1)):  # k quat, part by part
            self.quat_q30[i] += sign * (rounded_shift(self.quat_q14[3 - i] * turn, 8) << 3)

    def euler(self, held: list[int]) -> tuple[int, int, int]:
        """mahony_euler."""
        return exact_euler.euler(self.quat_q30, held)
