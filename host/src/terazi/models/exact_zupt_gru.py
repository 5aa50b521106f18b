# SPDX-License-Identifier: MIT
"""Twin of zupt_gru.h and port_gru.h in Python's unbounded integers, straight from their contracts.

Weights come as an argument: as terazi.design.zupt_gru makes them, or any others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from terazi.design.zupt_gru import Unit, Weights
from terazi.models.exact import COUNTER_MAX, rounded_shift

STEP_MS = 5
VALUES = range(-8192, 8192)
RAILS = (-(1 << 15), (1 << 15) - 1)
TEN = 10 << 10
INPUTS, UNITS = 2, 8

Vector = Sequence[int]


def octaves(halves: int, floor_q8: int) -> int:
    """log2 of half counts above the floor's, in steps of 1/256, from 0 to ten octaves in Q10."""
    if halves == 0:
        return 0
    whole = halves.bit_length() - 1
    part = 256 * (halves - (1 << whole)) >> whole
    bulge = (part * (256 - part) >> 8) * 88 >> 8
    return min(max(4 * ((whole << 8) + part + bulge - floor_q8), 0), TEN)


def sigmoid(table_q16: Sequence[int], value: int) -> int:
    """s of port_gru.h."""
    at = min(abs(value), 256 * (len(table_q16) - 1) - 1)
    piece, into = divmod(at, 256)
    low, high = table_q16[piece : piece + 2]
    found = low + (high - low) * into // 256
    return (1 << 16) - found if value < 0 else found


def share(value: int, q16: int) -> int:
    """value * q16 / 2^16, half up."""
    return rounded_shift(value * q16, 16)


def total(bias: int, weights: Sequence[int], seen: Sequence[int]) -> int:
    """A sum of port_gru.h."""
    products = sum(w * v for w, v in zip(weights, seen, strict=True))
    return rounded_shift(256 * bias + products, 8)


def next_state(unit: Unit, table_q16: Sequence[int], seen: Sequence[int], state: int) -> int:
    """What a unit is after a step."""
    inputs, states = zip(*unit.inputs, strict=True), zip(*unit.states, strict=True)
    (r_in, z_in, n_in), (r_st, z_st, n_st) = inputs, states
    reset = sigmoid(table_q16, total(unit.bias[0], r_in + r_st, seen) // 2)
    update = sigmoid(table_q16, total(unit.bias[1], z_in + z_st, seen) // 2)
    gated = share(total(unit.bias_u, n_st, seen[INPUTS:]), reset)
    fresh = sigmoid(table_q16, total(unit.bias[2], n_in, seen[:INPUTS]) + gated)
    fresh = (fresh - (1 << 15)) // 4
    return fresh + share(state - fresh, update)


class ZuptGru:
    """zupt_gru.h"""

    def __init__(self, weights: Weights, sample_ms: int) -> None:
        self.weights = weights
        self.sample_ms = sample_ms
        self.rejected = 0
        self.interrupt()

    def interrupt(self) -> None:
        """A gap in time."""
        self.seen = [0] * (INPUTS + UNITS)
        self.still = False
        self.time_ms = 0  # of the next sample
        self.is_due = False

    def update(self, gyro: Vector, acc: Vector) -> int:
        """One sample; gives the flag."""
        if self.is_due:
            self._conclude()
        # A step's time lies between this sample and the next one, or is this sample's.
        self.is_due = -self.time_ms % STEP_MS < self.sample_ms
        self.time_ms += self.sample_ms
        if self.is_due:
            w = self.weights
            self.seen[0] = self._magnitude(acc, w.gravity_halves, w.acc_floor)
            self.seen[1] = self._magnitude(gyro, 0, w.rate_floor)
        return int(self.still)

    def _magnitude(self, vector: Vector, start: int, floor_q8: int) -> int:
        if any(value in RAILS for value in vector):
            self.rejected = min(self.rejected + 1, COUNTER_MAX)
        if not all(value in VALUES for value in vector):
            return TEN
        halves = math.isqrt(4 * sum(value * value for value in vector))
        return octaves(abs(halves - start), floor_q8)

    def _conclude(self) -> None:
        w = self.weights
        states = [
            next_state(unit, w.sigmoid_q16, self.seen, self.seen[INPUTS + n])
            for n, unit in enumerate(w.units)
        ]
        self.seen[INPUTS:] = states
        score = 256 * w.out_bias + sum(a * b for a, b in zip(w.out, states, strict=True))
        self.still = score >= 0 and max(self.seen[:INPUTS]) < TEN
