# SPDX-License-Identifier: MIT
"""Twin of zupt.h in Python's unbounded integers, straight from its contract."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from terazi.models.exact import COUNTER_MAX

BLOCK = 4
GRAVITY = 2048
VALUES = range(-4096, 4096)
RAILS = (-(1 << 15), (1 << 15) - 1)
OFF, SHOE, ARE, MOVING_VARIANCE, MAGNITUDE = range(5)

Vector = Sequence[int]


def dot(a: Vector, b: Vector) -> int:
    """Inner product."""
    return sum(x * y for x, y in zip(a, b, strict=True))


class Zupt:
    """zupt.h; `config` has the fields of zupt_config_t."""

    def __init__(self, config: Mapping) -> None:
        self.config = config
        self.samples = 0
        self.still = False
        self.quiet = 0
        self.rejected = 0
        self.rates: list[Vector] = []
        self.accs: list[Vector] = []
        self.visit = 0

    def interrupt(self) -> None:
        """A gap in time."""
        self.still, self.quiet = False, 0
        self._begin_block()

    def update(self, gyro: Vector, acc: Vector) -> int:
        """One sample; gives the flag."""
        if self.config["detector"] == OFF:
            return 0
        visited = self.samples % self.config["stride"] == 0
        self.samples += 1
        if not visited:
            return int(self.still)
        visit, self.visit = self.visit, self.visit + 1
        if visit == 2 * BLOCK:
            self._judge()
        elif visit % 2 == 0 and self.config["detector"] != ARE:
            self._take(acc, self.accs)
        elif visit % 2 == 1 and self.config["detector"] in (SHOE, ARE):
            self._take(gyro, self.rates)
        return int(self.still)

    @property
    def statistic(self) -> int:
        """The whole block's sum of squares."""
        detector = self.config["detector"]
        rate = self.config["gyro_weight"] * sum(dot(w, w) for w in self.rates)
        if detector == ARE:
            return rate
        if detector == MAGNITUDE:
            return sum(4 * self._off_gravity(dot(a, a), 1) for a in self.accs)
        total = [sum(a[axis] for a in self.accs) for axis in range(3)]
        square = dot(total, total)
        spread = sum(dot(a, a) for a in self.accs) - square // BLOCK
        if detector == MOVING_VARIANCE:
            return spread
        return rate + spread + BLOCK * self._off_gravity(square, BLOCK * BLOCK)

    @staticmethod
    def _off_gravity(square: int, times: int) -> int:
        """floor((square / times - g^2) / 2g)^2"""
        return ((square - times * GRAVITY**2) // (times * 2 * GRAVITY)) ** 2

    def _take(self, vector: Vector, into: list[Vector]) -> None:
        into.append(vector)
        # Axis by axis: what lies behind the first value that is beyond is not seen.
        for value in vector:
            if value not in VALUES:
                if value in RAILS:
                    self.rejected = min(self.rejected + 1, COUNTER_MAX)
                self.interrupt()
                return

    def _judge(self) -> None:
        limit = -self.config["begin_squares"][int(self.still)]
        if self.statistic >= limit:
            self.interrupt()
            return
        if not self.still:
            self.quiet += 1
            self.still = self.quiet == self.config["still_blocks"]
        self._begin_block()

    def _begin_block(self) -> None:
        self.visit, self.rates, self.accs = 0, [], []
