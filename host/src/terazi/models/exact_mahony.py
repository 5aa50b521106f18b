# SPDX-License-Identifier: MIT
"""Twin of mahony.h and port_turn.h in Python's unbounded integers, from their contracts."""

from __future__ import annotations

import copy
from collections.abc import Mapping

from terazi.models import exact_euler
from terazi.models.exact import COUNTER_MAX, rounded_shift
from terazi.models.exact_vectors import (
    ONE_Q14,
    Carries,
    Root,
    Vector,
    cross,
    dot,
    half_turn_q14,
    int16,
    limit,
    normalised,
    quaternion_product,
    shift_14,
)

SECOND_ORDER, LINEAR, CLASSIC = range(3)
INTEGRAL_MAX_Q22 = 328 << 22
MEAN_END_Q14 = 1 << 27
RAMP_BLOCK = 16
MAG_BLOCK = 8
COUNTS = ("acc_zero", "railed", "mag_refused", "mag_disturbed", "gaps")


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
        self.ramp_left = self.lowpass = self.correct_gain = 0
        self.started = False
        self.carry = Carries()
        for i in range(3):
            self.carry.kept["rate", i] = self.carry.kept["turn", i] = 1 << 15
        self.cut = [128] * 4
        self.counts = dict.fromkeys(COUNTS, 0)
        self.field = None
        self.settling = self.config["mag_settle_len"]
        self.undisturbed = self.accepted = self.rejected = 0
        self.phase = self.heading_gain = self.level2 = 0
        self.sums, self.whole, self.refused = [0, 0], False, False

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

    def _forget_level(self) -> None:
        self.level = self.mean[(self.sample + 1) % 2]

    def up(self) -> list[int]:
        """Third row of the rotation matrix."""
        return [shift_14(value) for value in cross(*self.rows)]

    def free_acceleration(self, acc: Vector) -> list[int]:
        """acc less gravity, body axes."""
        one_g = self.config["acc_one_g"]
        gravity = [shift_14(value * one_g) for value in self.up()]
        return [int16(a - g) for a, g in zip(acc, gravity, strict=True)]

    def _turn_world(self, left_q14: Vector) -> None:
        right = [rounded_shift(value, 16) for value in self.quat_q30]
        self.quat_q30 = normalised([4 * v for v in quaternion_product(left_q14, right)])
        self.cut = [128] * 4
        self._still()

    def _start(self, acc: Vector) -> None:
        acc_w = [int16(shift_14(dot(row, acc))) for row in (*self.rows, self.up())]
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
        self.lowpass = self._raised(self.config["lowpass_q16"])
        self.correct_gain = min(4095, self._raised(self.config["correct_q18"]))
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
            length = root.length()
            level = min(max(shift_14(level), -length), length)
            self.mean[axis] = root.unit_q14(int16(level)) * 2048

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
            self.lowpass = self._raised(self.config["lowpass_q16"])
        if self.sample % RAMP_BLOCK == RAMP_BLOCK // 2:
            self.correct_gain = min(4095, self._raised(self.config["correct_q18"]))

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

    def _scaled(self, row: Vector, mag: Vector) -> int:
        value = dot(row, mag)
        fine = value if self.config["mag_times_64"] else (value >> 8) * 4
        return int16(rounded_shift(fine, 8))

    def update_mag(self, mag: Vector) -> None:
        """mahony_update_mag."""
        if not self.started:
            return
        level = [self._scaled(row, mag) for row in self.rows]
        if self.field is None:
            self._start_heading(mag, level)
            return
        if self.whole:
            self._work(mag)
        self.sums = [total + part for total, part in zip(self.sums, level, strict=True)]
        self.phase = (self.phase + 1) % MAG_BLOCK
        self.whole = self.whole or self.phase == 0

    def _work(self, mag: Vector) -> None:
        if self.phase == 0:
            self.mean_field, self.sums = [rounded_shift(total, 3) for total in self.sums], [0, 0]
            self.level2 = dot(self.mean_field, self.mean_field)
        elif self.phase == 1:
            self.up_field = self._scaled(self.up(), mag)
        elif self.phase == 2:
            self._measure()
        elif self.phase == 3:
            if not self.refused:
                self._learn("smooth", self.measured, self.config["mag_smooth_q16"])
        elif self.phase == 4:
            self._judge_reference()
        elif self.phase == 5:
            self._judge_candidate()
        elif self.phase == 6:
            self._decide()
        elif not self.refused:
            self._turn_heading()

    def _measure(self) -> None:
        norm2 = self.level2 + self.up_field**2
        self.refused = self.level2 <= norm2 >> 8
        if self.refused:
            self._count("mag_refused")
            return
        root = Root(norm2)
        self.measured = (min(32767, root.length()), int16(2 * root.unit_q14(self.up_field)))

    def _start_heading(self, mag: Vector, level: list[int]) -> None:
        self.level2, self.up_field = dot(level, level), self._scaled(self.up(), mag)
        self._measure()
        if self.refused:
            return
        root = Root(self.level2)
        east, north = (root.unit_q14(part) for part in level)
        (larger, smaller), ahead = half_turn_q14(north, (east,))
        self._turn_world((larger, 0, 0, smaller) if ahead else (smaller, 0, 0, larger))
        names = ("smooth", "reference", "candidate")
        self.field = {name: [value << 16 for value in self.measured] for name in names}

    def _turn_heading(self) -> None:
        east, north = self.mean_field
        sine = Root(self.level2).unit_q14(east)
        if north < 0:
            sine = ONE_Q14 if sine > 0 else -ONE_Q14
        turn = self.carry("heading", 4 * sine * self.heading_gain)
        k_quat = quaternion_product((0, 0, 0, 1), self.quat_q14)
        for i, part in enumerate(k_quat):
            self.quat_q30[i] += rounded_shift(part * turn, 5)

    def _learn(self, name: str, measured: Vector, gain: int) -> None:
        state = self.field[name]
        for i, target in enumerate(measured):
            state[i] += (target - (state[i] >> 16)) * gain

    def _near(self, name: str) -> bool:
        smooth, other = ([v >> 16 for v in self.field[key]] for key in ("smooth", name))
        norm_max = other[0] * 6554 >> 16
        return abs(smooth[0] - other[0]) < norm_max and abs(smooth[1] - other[1]) < 5571

    def _smooth(self) -> list[int]:
        return [value >> 16 for value in self.field["smooth"]]

    def _judge_reference(self) -> None:
        if self._near("reference"):
            self.undisturbed = min(self.undisturbed + 1, COUNTER_MAX)
            self._learn("reference", self._smooth(), self.config["mag_learn_q16"])
        else:
            self.undisturbed = 0

    def _judge_candidate(self) -> None:
        if self._near("candidate"):
            if any(abs(rate) > self.config["moving_min"] for rate in self.rate):
                self.accepted = min(self.accepted + 1, COUNTER_MAX)
            self._learn("candidate", self._smooth(), self.config["mag_learn_q16"])
        else:
            self.accepted, self.field["candidate"] = 0, self.field["smooth"][:]

    def _disturbed(self) -> bool:
        if self.settling:
            self.settling -= 1
            return False
        if self.undisturbed >= self.config["mag_recover_len"]:
            return False
        if self.accepted <= self.config["mag_accept_len"]:
            return True
        self.field["reference"] = self.field["candidate"][:]
        self.undisturbed, self.accepted = self.config["mag_recover_len"], 0
        return False

    def _decide(self) -> None:
        self.heading_gain = min(16383, self._raised(self.config["mag_correct_q21"]))
        if not self._disturbed():
            self.rejected = max(0, self.rejected - 2)
            return
        self._count("mag_disturbed")
        if self.rejected >= self.config["mag_reject_len"]:
            self.heading_gain >>= 1
        else:
            self.rejected += 1
            self.heading_gain = 0

    def euler(self, held: list[int]) -> tuple[int, int, int]:
        """mahony_euler."""
        return exact_euler.euler(self.quat_q30, held)
