# SPDX-License-Identifier: MIT
"""Twin of checkweigher.h in Python's unbounded integers, straight from its contract."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from itertools import pairwise

from terazi.models.exact import COUNTER_MAX, rounded_shift

MASS_MAX, SPREAD_MG = 1 << 30, 1 << 22
CLASSES_MAX, SAMPLES_MAX = 8, 32
TIME_MAX_US, GAP_MAX_US = 4_000_000, 500_000
CLOCK_US, CLOCK_256US = 1 << 32, 1 << 24
EMPTY, LOADED, VERDICT, UNWEIGHED = range(4)


def is_lawful(config: Mapping) -> bool:
    """What checkweigher_init answers."""
    if not 1 <= config["classes"] <= CLASSES_MAX:
        return False
    limits = config["limit_mg"][: config["classes"] - 1]
    rising = all(low < high for low, high in pairwise(limits))
    return (
        rising
        and all(abs(limit) <= MASS_MAX for limit in limits)
        and 0 < config["leave_mg"] < config["enter_mg"] <= MASS_MAX
        and 1 <= config["samples_min"] <= SAMPLES_MAX
        and 0 <= config["settle_us"] <= TIME_MAX_US
        and 0 <= config["tail_us"] <= TIME_MAX_US
        and 1 <= config["gap_us"] <= GAP_MAX_US
    )


def weighted_mean(masses: list[int]) -> int | None:
    """The weight of a stretch, None where it spreads too far."""
    base, count = masses[0], len(masses)
    if max(abs(mass - base) for mass in masses) > SPREAD_MG:
        return None
    weights = [min(n + 1, count - n) for n in range(count)]
    total = sum(w * (mass - base) for w, mass in zip(weights, masses, strict=True))
    off = rounded_shift(abs(total) * ((1 << 32) // sum(weights)), 32)
    return base - off if total < 0 else base + off


class Checkweigher:
    """checkweigher.h; `config` has the fields of checkweigher_config_t."""

    def __init__(self, config: Mapping) -> None:
        if not is_lawful(config):
            raise ValueError("checkweigher.h refuses this configuration")
        self.config = config
        self.loaded = self.broken = False
        self.ring: deque[tuple[int, int]] = deque(maxlen=SAMPLES_MAX)
        self.mass_mg = self.class_at = self.samples = self.unweighed = self.weighed = 0
        self.counts = [0] * CLASSES_MAX
        self.last_us = self.entered_us = self.left_us = self.interval_us = 0

    def update(self, mass_mg: int, device_us: int) -> int:
        """Take one mass; gives the event."""
        elapsed_us, self.last_us = (device_us - self.last_us) % CLOCK_US, device_us
        mass = min(max(mass_mg, -MASS_MAX), MASS_MAX)
        if not self.loaded:
            if mass < self.config["enter_mg"]:
                return EMPTY
            self.loaded, self.broken, self.entered_us = True, False, device_us
            self.ring.clear()
        else:
            self.broken |= elapsed_us > self.config["gap_us"]
            if mass < self.config["leave_mg"]:
                self.loaded = False
                return self._finish(device_us)
        since = (device_us - self.entered_us) % CLOCK_US
        if self.ring or since >= self.config["settle_us"]:
            self.ring.append((mass, device_us >> 8))
        return LOADED

    def _finish(self, device_us: int) -> int:
        self._pace(device_us)
        now, tail = device_us >> 8, self.config["tail_us"] >> 8
        stretch: list[int] = []
        for mass, stamp in self.ring:
            if (now - stamp) % CLOCK_256US % (1 << 16) < tail:
                break
            stretch.append(mass)
        weight = None
        if not self.broken and len(stretch) >= self.config["samples_min"]:
            weight = weighted_mean(stretch)
        if weight is None:
            self.unweighed = min(self.unweighed + 1, COUNTER_MAX)
            return UNWEIGHED
        self.mass_mg, self.samples = weight, len(stretch)
        limits = self.config["limit_mg"][: self.config["classes"] - 1]
        self.class_at = sum(weight >= limit for limit in limits)
        self.counts[self.class_at] += 1
        self.weighed += 1
        return VERDICT

    def _pace(self, device_us: int) -> None:
        elapsed_us = (device_us - self.left_us) % CLOCK_US
        self.left_us = device_us
        if self.weighed + self.unweighed == 0:
            return
        mean = self.interval_us
        self.interval_us = mean - (mean >> 3) + (elapsed_us >> 3) if mean else elapsed_us

    @property
    def per_minute_q8(self) -> int:
        if self.interval_us == 0 or self.interval_us > 1 << 31:
            return 0
        return min((60_000_000 << 8) // self.interval_us, 65535)
