# SPDX-License-Identifier: MIT
"""Twin of mahony_euler in Python's unbounded integers."""

from __future__ import annotations

import math
from collections.abc import Sequence

from terazi.models.exact import rounded_shift

PI_Q16, HALF_PI_Q16 = 205887, 102944
LOCK_Q30 = 0x20000
INVERSE_Q8 = [math.floor(32768 / (i + 0.5) + 0.5) for i in range(128, 256)]
ANGLE_Q16 = [math.floor(math.atan(i / 64) * 65536 + 0.5) for i in range(65)]
LENGTH_Q15 = [math.floor(math.hypot(1, i / 64) * 32768 + 0.5) for i in range(65)]


def euler(quat_q30: Sequence[int], held: list[int]) -> tuple[int, int, int]:
    """Roll, pitch and yaw, rad Q13; held: half sum and half difference, kept there."""
    w, x, y, z = quat_q30
    sum_angle, sum_length = _half_angle(w - y, z + x, held, 0)
    diff_angle, diff_length = _half_angle(w + y, z - x, held, 1)
    pitch, _ = _polar(sum_length >> 1, diff_length >> 1)
    return (
        _wrapped_q13(sum_angle - diff_angle),
        _wrapped_q13(2 * pitch - HALF_PI_Q16),
        _wrapped_q13(sum_angle + diff_angle),
    )


def _between(table: Sequence[int], ratio_q16: int) -> int:
    place, rest = divmod(ratio_q16, 1024)
    return table[place] + rounded_shift((table[place + 1] - table[place]) * rest * 64, 16)


def _polar(x: int, y: int) -> tuple[int, int]:
    """Angle (Q16) and length of (x, y)."""
    small, large = sorted((abs(x), abs(y)))
    shift = max(0, 31 - large.bit_length())
    large_q16, small_q16 = (value << shift >> 15 for value in (large, small))
    guess = INVERSE_Q8[(large_q16 >> 8) - 128]
    two_q15 = 2**24 - large_q16 * guess >> 8
    inverse_q15 = min(65535, rounded_shift(guess * two_q15, 7))
    ratio_q16 = min(65535, small_q16 * inverse_q15 >> 15)
    angle = _between(ANGLE_Q16, ratio_q16)
    if abs(y) > abs(x):
        angle = HALF_PI_Q16 - angle
    if x < 0:
        angle = PI_Q16 - angle
    return -angle if y < 0 else angle, large_q16 * _between(LENGTH_Q15, ratio_q16) >> shift


def _half_angle(x: int, y: int, held: list[int], which: int) -> tuple[int, int]:
    if max(abs(x), abs(y)) < LOCK_Q30:
        return held[which] * 8, 0
    angle, length = _polar(x, y)
    held[which] = _wrapped_q13(angle)
    return angle, length


def _wrapped_q13(angle_q16: int) -> int:
    if angle_q16 > PI_Q16:
        angle_q16 -= 2 * PI_Q16
    if angle_q16 < -PI_Q16:
        angle_q16 += 2 * PI_Q16
    return rounded_shift(angle_q16, 3)
