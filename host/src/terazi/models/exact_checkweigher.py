# SPDX-License-Identifier: MIT
"""Twin of checkweigher.h in Python's unbounded integers, straight from its contract."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

from terazi.models.exact import COUNTER_MAX, rounded_shift

BASE_MAX = (1 << 15) - 1  # of a base in half units
CLASSES_MAX, SAMPLES_MIN, SAMPLES_MAX = 8, 12, 32
HELD_MAX = 255
MINUTE_32US_OVER_256 = 60_000_000 // (32 * 256)
CLOCK_US = 1 << 32
EMPTY, LOADED, VERDICT, UNWEIGHED = range(4)
STEPS = 3
LEVEL, LEVEL_DOWN, TONE_SHIFT = 1 << 14, 3, 4


def is_lawful(config: Mapping) -> bool:
    """What checkweigher_init answers, of a configuration within its ranges."""
    limits = config["limit_mg"][: config["classes"] - 1]
    rising = all(low < high for low, high in pairwise(limits))
    return rising and config["leave_mg"] < config["enter_mg"]


def share_of(a: int, b: int) -> int:
    """a b / 2^32, half up."""
    return rounded_shift(a * b, 32)


def smoothed(offs: list[int]) -> list[int]:
    """Each mass with its neighbours, 1 4 6 4 1: means of two, halves down and up in turn."""
    for half in (0, 1, 0, 1):
        offs = [(left + right + half) >> 1 for left, right in pairwise(offs)]
    return offs


def levelled(z: list[int], mean: int) -> tuple[list[int], int]:
    """About the mean, times 2^up / 8, so that the largest uses 13 bits; and up."""
    about = [value - mean for value in z]
    largest = max(1, *(value if value >= 0 else ~value for value in about))
    up = max(0, LEVEL.bit_length() - largest.bit_length())
    return [(value << up) >> LEVEL_DOWN for value in about], up


def tone_share(z: list[int], over_count: int, up: int) -> int:
    """What the tone has put into the sum, the other way round, in half units; 0 without one."""
    inner = range(1, len(z) - 1)
    u = [z[n] for n in inner]
    v = [z[n - 1] - 2 * z[n] + z[n + 1] for n in inner]
    d = [z[n + 1] - z[n - 1] for n in inner]

    def moment(a: list[int], b: list[int]) -> int:
        return sum(x * y for x, y in zip(a, b, strict=True))

    def minor(a: int, b: int, c: int, e: int) -> int:
        return share_of(a, b) - share_of(c, e)

    uv, uu, ud = (moment(u, other) for other in (v, u, d))
    dd = moment(d, d) - share_of(sum(d) ** 2, over_count)
    vd = moment(v, d) - share_of(sum(v) * sum(d), over_count)
    det = minor(uu, dd, ud, ud)
    g = minor(vd, ud, uv, dd)
    fade = minor(vd, uu, uv, ud)
    top = minor(sum(v) << 16, det, sum(d) << 16, fade)
    if g <= det >> TONE_SHIFT or abs(top) >= g:
        return 0
    share = ((abs(top) << 32) // g) >> (15 - LEVEL_DOWN + up)
    return -share if top < 0 else share


def constant(smooth: list[int]) -> int:
    """The constant under the tone, in half units."""
    inner = smooth[1:-1]
    over_count = (1 << 32) // len(inner)
    z, up = levelled(smooth, share_of(sum(inner), over_count))
    return share_of(2 * sum(inner) + tone_share(z, over_count, up), over_count)


def weight(masses: list[int]) -> int:
    """The weight of a stretch, which wraps as int32 does."""
    base = masses[0]
    shift = 0
    while base >> shift >= BASE_MAX:
        shift += 1
    offs = [(((mass - base) >> shift) + 1) >> 1 for mass in masses]
    found = base + (constant(smoothed(offs)) << shift)
    return (found + (1 << 31)) % (1 << 32) - (1 << 31)


class Checkweigher:
    """checkweigher.h; `config` has the fields of checkweigher_config_t."""

    def __init__(self, config: Mapping) -> None:
        if not is_lawful(config):
            raise ValueError("checkweigher.h refuses this configuration")
        self.config = config
        self.loaded = self.broken = False
        self.found = 0
        self.held: list[int] = []
        self.mass_mg = self.class_at = self.samples = self.pending = 0
        self.weighed = self.unweighed = 0
        self.last_us = self.entered_us = self.left_us = self.interval_32us = 0

    def update(self, mass_mg: int, device_us: int) -> int:
        """Take one mass; gives the event."""
        elapsed_us, self.last_us = (device_us - self.last_us) % CLOCK_US, device_us
        busy, verdict = self.pending > 0, self.pending == 1
        self.pending = max(0, self.pending - 1)
        if verdict:
            self._judge()
        event = self._follow(mass_mg, device_us, elapsed_us, busy=busy)
        return VERDICT if verdict else event

    def interrupt(self) -> None:
        """checkweigher_interrupt."""
        self.broken = True

    def _follow(self, mass: int, device_us: int, elapsed_us: int, *, busy: bool) -> int:
        if not self.loaded:
            if mass < self.config["enter_mg"]:
                return EMPTY
            self.loaded, self.broken, self.entered_us = True, False, device_us
            self.held = []
        else:
            self.broken |= elapsed_us > self.config["gap_us"]
            if mass < self.config["leave_mg"]:
                return LOADED if busy else self._finish(device_us, elapsed_us)
        since = (device_us - self.entered_us) % CLOCK_US
        if not busy and since >= self.config["settle_us"]:
            self.held = [*self.held, mass][:HELD_MAX]
            self.broken |= mass - self.held[0] > self.held[0]
        return LOADED

    def _finish(self, device_us: int, elapsed_us: int) -> int:
        self.loaded = False
        self._pace(device_us)
        ages = (elapsed_us * (k + 1) for k in range(len(self.held)))
        young = sum(age < self.config["tail_us"] for age in ages)
        self.samples = min(len(self.held) - young, SAMPLES_MAX)
        whole = not self.broken and self.samples >= self.config["samples_min"]
        if not whole:
            self.unweighed = min(self.unweighed + 1, COUNTER_MAX)
            return UNWEIGHED
        self.found, self.pending = weight(self.held[: self.samples]), STEPS
        return EMPTY

    def _judge(self) -> None:
        self.mass_mg = self.found
        limits = self.config["limit_mg"][: self.config["classes"] - 1]
        self.class_at = sum(self.mass_mg >= limit for limit in limits)
        self.weighed += 1

    def _pace(self, device_us: int) -> None:
        elapsed_us = (device_us - self.left_us) % CLOCK_US
        self.left_us = device_us
        if self.weighed + self.unweighed == 0:
            return
        mean = self.interval_32us or elapsed_us >> 5
        self.interval_32us = mean - (mean >> 3) + (elapsed_us >> 8)

    @property
    def per_minute_q8(self) -> int:
        if self.interval_32us == 0:
            return 0
        return min((MINUTE_32US_OVER_256 << 16) // self.interval_32us, 65535)
