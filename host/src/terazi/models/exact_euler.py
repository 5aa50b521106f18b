# SPDX-License-Identifier: MIT
"""Twin of mahony_euler in Python's unbounded integers."""

from __future__ import annotations

import math
from collections.abc import Sequence

from terazi.models.exact import rounded_shift

HALF_TURN, QUARTER_TURN = 1 << 15, 1 << 14  # angles are in 2^-16 of a turn
LOCK_Q30 = 0x20000
INVERSE_Q8 = [math.floor(32768 / (i + 0.5) + 0.5) for i in range(128, 256)]
ANGLE_TURN18 = [math.floor(math.atan(i / 64) / math.pi * 131072 + 0.5) for i in range(65)]
LENGTH_Q15 = [math.floor(math.hypot(1, i / 64) * 32768 + 0.5) for i in range(65)]


def euler(quat_q30: Sequence[int], held: list[int]) -> tuple[int, int, int]:
    """Roll, pitch and yaw, rad Q13; held: half sum and half difference, kept there."""
    w, x, y, z = quat_q30
    lengths = [_half_angle(w - y, z + x, held, 0), _half_angle(w + y, z - x, held, 1)]
    pitch, _ = _polar(*lengths)
    return (
        _rad_q13(held[0] - held[1]),
        _rad_q13(2 * pitch - QUARTER_TURN),
        _rad_q13(held[0] + held[1]),
    )


def _between(table: Sequence[int], ratio_q16: int) -> int:
    place, rest = divmod(ratio_q16, 1024)
    return table[place] + rounded_shift((table[place + 1] - table[place]) * rest * 64, 16)


def _polar(x: int, y: int) -> tuple[int, int]:
    """Angle and half the length of (x, y)."""
    small, large = sorted((abs(x), abs(y)))
    shift = 32 - large.bit_length()
    large_q16, small_q16 = (value << shift >> 16 for value in (large, small))
    guess = INVERSE_Q8[(large_q16 >> 8) - 128]
    two_q15 = 2**24 - large_q16 * guess >> 8
    inverse_q15 = min(65535, rounded_shift(guess * two_q15, 7))
    ratio_q16 = min(65535, small_q16 * inverse_q15 >> 15)
    angle = rounded_shift(_between(ANGLE_TURN18, ratio_q16), 2)
    if abs(y) > abs(x):
        angle = QUARTER_TURN - angle
    if x < 0:
        angle = HALF_TURN - angle
    return -angle if y < 0 else angle, large_q16 * _between(LENGTH_Q15, ratio_q16) >> shift


def _half_angle(x: int, y: int, held: list[int], which: int) -> int:
    if max(abs(x), abs(y)) < LOCK_Q30:
        return 0
    held[which], half_length = _polar(x, y)
    return half_length


def _rad_q13(turn16: int) -> int:
    wrapped = (turn16 + HALF_TURN) % (2 * HALF_TURN) - HALF_TURN
    return rounded_shift(wrapped * 25736, 15)
