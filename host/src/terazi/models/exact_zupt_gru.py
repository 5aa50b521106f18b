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
BLOCK_STEPS, BLOCKS = 64, 3

Vector = Sequence[int]


def log2_q8(number: int) -> int:
    """As port_gru.h has it, of a positive number."""
    whole = number.bit_length() - 1
    part = 256 * (number - (1 << whole)) >> whole
    bulge = (part * (256 - part) >> 8) * 88 >> 8
    return (whole << 8) + part + bulge


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
    return bias + sum(w * v // 256 for w, v in zip(weights, seen, strict=True))


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
        self.best = [0] * BLOCKS  # of each block of steps, the newest first
        self.steps = 0  # of the newest block
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
            away = abs(math.isqrt(4 * self._square(acc)) - w.gravity_halves)
            self.seen[0] = self._octaves(acc, away, w.acc_floor, 4)
            square, floor = self._square(gyro), w.rate_floor
            while square > 0xFFFF:
                square, floor = square // 256, floor - 8 * 256
            self.seen[1] = self._octaves(gyro, square, floor, 2)
        return int(self.still)

    @staticmethod
    def _square(vector: Vector) -> int:
        return sum(value * value for value in vector)

    def _octaves(self, vector: Vector, number: int, floor_q8: int, share: int) -> int:
        """Of a number that was made of this vector: log2 above a floor, Q8 times `share`."""
        if any(value in RAILS for value in vector):
            self.rejected = min(self.rejected + 1, COUNTER_MAX)
        if not all(value in VALUES for value in vector):
            return TEN
        return min(max((log2_q8(number) - floor_q8) * share, 0), TEN) if number else 0

    def _conclude(self) -> None:
        w = self.weights
        states = [
            next_state(unit, w.sigmoid_q16, self.seen, self.seen[INPUTS + n])
            for n, unit in enumerate(w.units)
        ]
        self.seen[INPUTS:] = states
        score = total(w.out_bias, w.out, states)
        self.still = score >= self._asked(score) and max(self.seen[:INPUTS]) < TEN

    def _asked(self, score: int) -> int:
        """The least score that is still, after a step of this one."""
        gate = self.weights.gate
        if self.steps == BLOCK_STEPS:
            self.best, self.steps = [score, *self.best[:-1]], 0
        self.steps += 1
        self.best[0] = max(self.best[0], score)
        return min(max(max(self.best) - gate.margin, gate.least), 0)
