# SPDX-License-Identifier: MIT
"""Twins of imu_cal.h and rest.h in Python's unbounded integers, straight from their contracts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from terazi.models.exact import COUNTER_MAX, rounded_shift

INT16_MIN, INT16_MAX = -(1 << 15), (1 << 15) - 1
RAILS = (INT16_MIN, INT16_MAX)
BLOCK_ROUNDS = 16
FIRST_DIVISOR = 8  # of still_rounds, until the bias is known
AT_REST, BIAS_KNOWN = 1, 2

Vector = Sequence[int]


def imu_cal(
    raws: Iterable[Vector], matrix_q16: Sequence[Vector], offset_q3: Vector
) -> tuple[list[tuple[int, ...]], int]:
    """Calibrated vectors of imu_cal.h and its count of clipped ones."""
    results, clipped = [], 0
    for raw in raws:
        wanted = [
            raw[row]
            + rounded_shift(
                sum(d * value for d, value in zip(matrix_q16[row], raw, strict=True))
                - (offset_q3[row] << 13),
                16,
            )
            for row in range(3)
        ]
        limited = [_limited(value) for value in wanted]
        if limited != wanted or any(value in RAILS for value in raw):
            clipped = min(clipped + 1, COUNTER_MAX)
        results.append(tuple(limited))
    return results, clipped


def _limited(value: int) -> int:
    return min(max(value, INT16_MIN), INT16_MAX)


def offset_at_temperature(
    offset_q3: Vector, slope_q16: Vector, above_reference: int
) -> tuple[int, ...]:
    """offset_q3 of a sensor so much warmer, imu_cal.h."""
    return tuple(
        _limited(offset + rounded_shift(slope * above_reference, 13))
        for offset, slope in zip(offset_q3, slope_q16, strict=True)
    )


def imu_cal_turn(orientation: int, vector: Vector) -> tuple[int, ...]:
    """A vector on the board's axes, imu_cal.h; ValueError where no board can stand so."""
    axes = [orientation & 3, orientation >> 3 & 3]
    if not 0 <= orientation < 64 or 3 in axes or axes[0] == axes[1]:
        raise ValueError(f"no orientation {orientation}")
    rows = [[0, 0, 0], [0, 0, 0]]
    for row, axis, negated in zip(rows, axes, (orientation & 4, orientation & 32), strict=True):
        row[axis] = -1 if negated else 1
    x, y = rows
    z = [x[i - 2] * y[i - 1] - x[i - 1] * y[i - 2] for i in range(3)]
    return tuple(
        _limited(sum(e * value for e, value in zip(row, vector, strict=True))) for row in (x, y, z)
    )


class Rest:
    """rest.h; `config` has the fields of rest_config_t."""

    def __init__(self, config: Mapping[str, int]) -> None:
        self.config = config
        self.low_q16 = [0] * 6
        self.bias_q16 = [0, 0, 0]
        self.sums = [0, 0, 0]
        self.samples = 0
        self.rounds = 0  # ended since motion or, at rest, in this block
        self.blocks = 0
        self.at_rest = self.bias_known = False
        self.rejected = self.implausible = 0

    def interrupt(self) -> None:
        """A gap in time."""
        self.at_rest, self.rounds = False, 0

    def update(self, gyro: Vector, acc: Vector) -> int:
        """One sample; gives the flags."""
        visit = self.samples % 6
        self.samples += 1
        learning_round = self.at_rest and self.rounds == BLOCK_ROUNDS
        if learning_round and visit == 0:
            self._end_block()
        elif learning_round and visit >= 3:
            self._learn(visit - 3)
        elif not self._is_still(visit, (*acc, *gyro)[visit]):
            self.interrupt()
            return self.flags
        elif self.at_rest and visit >= 3:
            self._gather(visit - 3, gyro[visit - 3])
        if visit == 5:
            self._end_round()
        return self.flags

    @property
    def flags(self) -> int:
        """What update answers."""
        return AT_REST * self.at_rest | BIAS_KNOWN * self.bias_known

    def _is_still(self, visit: int, sample: int) -> bool:
        if sample in RAILS:
            self.rejected = min(self.rejected + 1, COUNTER_MAX)
            return False
        sensor = "acc" if visit < 3 else "gyro"
        off = sample - (self.low_q16[visit] >> 16)
        if abs(off) > self.config[f"{'leave' if self.at_rest else 'enter'}_{sensor}_counts"]:
            self.low_q16[visit] = sample << 16
            return False
        self.low_q16[visit] += self.config["lowpass_q16"] * off
        return visit < 3 or abs(self.low_q16[visit] >> 16) <= self.config["bias_max_counts"]

    def _gather(self, axis: int, sample: int) -> None:
        if self.rounds < BLOCK_ROUNDS:
            self.sums[axis] = sample + (self.sums[axis] if self.rounds else 0)

    def _learn(self, axis: int) -> None:
        mean_q16 = self.sums[axis] * (65536 // BLOCK_ROUNDS)
        self.bias_q16[axis] += (mean_q16 - self.bias_q16[axis]) >> self.blocks.bit_length() - 1

    def _end_block(self) -> None:
        square = sum(rounded_shift(low >> 16, 8) ** 2 for low in self.low_q16[:3])
        if self.config["gravity2_min"] <= square <= self.config["gravity2_max"]:
            self.blocks = min(self.blocks + 1, self.config["gain_len"])
        else:
            self.implausible = min(self.implausible + 1, COUNTER_MAX)
            self.rounds = 0

    def _end_round(self) -> None:
        ended, self.rounds = self.rounds, self.rounds + 1
        if not self.at_rest:
            asked = self.config["still_rounds"] // (1 if self.bias_known else FIRST_DIVISOR)
            if self.rounds == max(asked, 1):
                self.at_rest, self.rounds = True, 0
        elif ended == BLOCK_ROUNDS:
            self.bias_known, self.rounds = True, 0
