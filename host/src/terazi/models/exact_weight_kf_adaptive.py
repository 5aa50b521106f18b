# SPDX-License-Identifier: MIT
"""Twins of weight_kf_adaptive.c in unbounded integers, straight from the header's contract."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from terazi.models.exact import COUNTER_MAX, COUNTS_MAX, COUNTS_MIN, rounded_shift

GAIN_MAX_Q16 = (1 << 16) - 1
ROOT_HALF_PI_Q9 = 642  # sqrt(pi / 2): a normal deviate's sigma over its mean magnitude


@dataclass(frozen=True)
class Variant:
    """A variant of weight_kf_adaptive.toml as the C has it."""

    process_var_q16: int
    noise_q8: int
    noise_min_q8: int
    noise_max_q8: int


class Adaptive:
    """weight_kf_adaptive_t and its update."""

    def __init__(self, variant: Variant, first: int) -> None:
        self.variant = variant
        self.clipped = 0
        self.estimate_q23 = self.clamped_q7(first) << 16
        self.noise_q16 = variant.noise_q8 << 8
        self.var_q16 = self.noise_var_q16
        self.before_q7 = [self.estimate_q7] * 2

    @property
    def estimate_q7(self) -> int:
        """What is given: rounded down."""
        return self.estimate_q23 >> 16

    @property
    def noise_q8(self) -> int:
        """In whole 1/256 counts, as everything but the learning takes it."""
        return self.noise_q16 >> 8

    @property
    def noise_var_q16(self) -> int:
        """R."""
        return self.noise_q8**2

    def clamped_q7(self, counts: int) -> int:
        """A measurement in Q7, limited to 24 bits and counted if it had to be."""
        limited = min(max(counts, COUNTS_MIN), COUNTS_MAX)
        if limited != counts:
            self.clipped = min(self.clipped + 1, COUNTER_MAX)
        return limited << 7

    def update(self, measured: int) -> int:
        """The new estimate, Q7."""
        self.step(self.clamped_q7(measured), margin_q7=self.noise_q8 * 3 // 2)
        return self.estimate_q7

    def outside_q7(self, z_q7: int, margin_q7: int) -> int:
        """How far to go to come within the margin of what the last three measurements span."""
        span = (z_q7, *self.before_q7)
        low, high = min(span) - margin_q7, max(span) + margin_q7
        return min(max(self.estimate_q7, low), high) - self.estimate_q7

    def step(self, z_q7: int, *, margin_q7: int | None) -> None:
        """One update; without a margin the innovation test is left out."""
        jump = 0 if margin_q7 is None else self.outside_q7(z_q7, margin_q7)
        self.before_q7 = [z_q7, self.before_q7[0]]

        predicted = self.var_q16 + self.variant.process_var_q16
        total = predicted + self.noise_var_q16
        jump_q5 = min(abs(jump) >> 2, 65535)
        opened = jump_q5 * self.noise_q8  # |J| sigma / 8
        over = min(max(opened, predicted), total)
        gain_q16 = min((over << 16) // total, 65535)
        if opened > predicted:
            self.var_q16 = rounded_shift(gain_q16 * self.noise_var_q16, 16)
        else:
            rest = (over << 16) - gain_q16 * total
            self.var_q16 = predicted - rounded_shift(gain_q16 * (predicted + (rest >> 16)), 16)

        left = z_q7 - self.estimate_q7 - jump
        taken = min(abs(left), 2 * self.noise_q8)  # 4 sigma in Q7
        move_q23 = (abs(jump) << 16) + gain_q16 * taken
        self.estimate_q23 += move_q23 if left >= 0 else -move_q23
        self.learn(taken, max(4 * (self.noise_q8 // 2 - jump_q5), self.noise_q8 // 2), 8)

    def learn(self, taken_q7: int, cap_q7: int, shift: int) -> None:
        """Take an innovation's magnitude into the noise."""
        taught_q16 = min(taken_q7, cap_q7) * ROOT_HALF_PI_Q9
        self.noise_q16 += rounded_shift(taught_q16 - self.noise_q16, shift)
        low, high = self.variant.noise_min_q8 << 8, self.variant.noise_max_q8 << 8
        self.noise_q16 = min(max(self.noise_q16, low), high)


class Pair:
    """weight_kf_adaptive_pair_t and its update."""

    def __init__(self, variant: Variant, first: int) -> None:
        self.rest = Adaptive(variant, first)
        self.moving_q7 = self.rest.estimate_q7
        self.quiet = 0
        self.moving = False

    @property
    def clipped(self) -> int:
        """As the resting filter counts."""
        return self.rest.clipped

    def update(self, measured: int) -> int:
        """The estimate of the model that has the say, Q7."""
        rest = self.rest
        z_q7 = rest.clamped_q7(measured)
        innovation = z_q7 - self.moving_q7
        self.moving_q7 += rounded_shift(innovation, 1)
        if self.moving:
            self._follow(innovation)
        elif rest.outside_q7(z_q7, rest.noise_q8 * 3):
            self.moving, self.quiet, self.moving_q7 = True, 0, z_q7
        else:
            rest.step(z_q7, margin_q7=None)
        return self.moving_q7 if self.moving else rest.estimate_q7

    def _follow(self, innovation: int) -> None:
        rest, noise_q8 = self.rest, self.rest.noise_q8
        self.quiet = self.quiet + 1 if abs(innovation) < noise_q8 * 3 // 2 else 0
        if self.quiet == 8:
            self.moving = False
            rest.before_q7 = [self.moving_q7] * 2
            if abs(self.moving_q7 - rest.estimate_q7) > noise_q8:
                rest.estimate_q23, rest.var_q16 = self.moving_q7 << 16, noise_q8**2 >> 1
        rest.learn(abs(innovation), 2 * noise_q8, 11)


def adaptive(
    measured: Iterable[int], variant: Variant, first: int, *, pair: bool = False
) -> tuple[list[int], int]:
    """Estimates (Q7) of weight_kf_adaptive.h and the count of clipped values."""
    kf = (Pair if pair else Adaptive)(variant, first)
    return [kf.update(z) for z in measured], kf.clipped
