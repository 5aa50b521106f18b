# SPDX-License-Identifier: MIT
"""Vectors, quaternions and roots of mahony.h's twin, in Python's unbounded integers."""

from __future__ import annotations

from collections.abc import Sequence

from terazi.models.exact import rounded_shift

Vector = Sequence[int]
ONE_Q14 = 1 << 14


def limit(value: int, end: int) -> int:
    """value in -end .. end - 1."""
    return min(max(value, -end), end - 1)


def int16(value: int) -> int:
    """value limited to 16 bits."""
    return limit(value, 1 << 15)


def shift_14(value: int) -> int:
    """Of value without its last byte."""
    return rounded_shift(value >> 8, 6)


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


def ratio_q15(part: int, whole: int) -> int:
    """part / whole, cut; of sizes."""
    return (part << 15) // whole


def normalised(quat_q30: Vector) -> list[int]:
    """Norm 1 within 1e-6, of a norm within 2^-9 of 1."""
    high = [rounded_shift(value, 16) for value in quat_q30]
    rest = [(value - (h << 16)) >> 8 for value, h in zip(quat_q30, high, strict=True)]
    error_q28 = sum(h * h + (h * r >> 7) for h, r in zip(high, rest, strict=True)) - 2**28
    half = rounded_shift(error_q28, 5)
    square = half * half >> 24
    factor = square + (square >> 1) - half
    return [value + rounded_shift(h * factor, 8) for value, h in zip(quat_q30, high, strict=True)]
