# SPDX-License-Identifier: MIT
"""Twin of checkweigher.h in Python's unbounded integers, straight from its contract."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from itertools import pairwise

from terazi.models.exact import COUNTER_MAX, rounded_shift

MASS_MAX, OFF_MAX = 1 << 30, 1 << 14
CLASSES_MAX, SAMPLES_MIN, SAMPLES_MAX = 8, 12, 32
TIME_MAX_US, GAP_MAX_US = 4_000_000, 500_000
CLOCK_US = 1 << 32
EMPTY, LOADED, VERDICT, UNWEIGHED = range(4)
STEPS = 2
SPREAD_BITS, LARGE_BITS, TONE_SHIFT = 12, 29, 4


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
        and SAMPLES_MIN <= config["samples_min"] <= SAMPLES_MAX
        and 0 <= config["settle_us"] <= TIME_MAX_US
        and 0 <= config["tail_us"] <= TIME_MAX_US
        and 1 <= config["gap_us"] <= GAP_MAX_US
    )


def halved(value: int, times: int) -> int:
    """value / 2^times, half up."""
    return rounded_shift(value, times) if times else value


def share_of(a: int, b: int) -> int:
    """a b / 2^32, rounded half away from 0."""
    size = rounded_shift(abs(a) * abs(b), 32)
    return -size if (a < 0) != (b < 0) else size


def smoothed(offs: list[int]) -> list[int]:
    """Each mass with its neighbours, 1 4 6 4 1: means of two, halves down and up in turn."""
    for half in (0, 1, 0, 1):
        offs = [(left + right + half) >> 1 for left, right in pairwise(offs)]
    return offs


def moments(z: list[int], over_count: int) -> tuple[int, ...]:
    """Of x, its second difference v and its first d about their means: uu, uv, ud, vd, dd.

    The mean of x is 0 but for rounding.
    """
    u = z[1:-1]
    v = [z[n - 1] - 2 * z[n] + z[n + 1] for n in range(1, len(z) - 1)]
    d = [z[n + 1] - z[n - 1] for n in range(1, len(z) - 1)]

    def moment(a: list[int], b: list[int]) -> int:
        return sum(x * y for x, y in zip(a, b, strict=True))

    mean_vd = share_of(sum(d) * sum(v), over_count)
    mean_dd = share_of(sum(d) * sum(d), over_count)
    return (
        moment(u, u),
        moment(u, v),
        moment(u, d),
        moment(v, d) - mean_vd,
        moment(d, d) - mean_dd,
    )


def tone_share(z: list[int], over_count: int, shift: int) -> int:
    """What the tone has put into the sum, the other way round; 0 where there is none."""
    uu, uv, ud, vd, dd = moments(z, over_count)
    any_bits = abs(uu) | abs(uv) | abs(ud) | abs(vd) | abs(dd)
    if any_bits == 0:
        return 0
    up = max(0, LARGE_BITS + 1 - any_bits.bit_length())
    uu, uv, ud, vd, dd = (each << up for each in (uu, uv, ud, vd, dd))
    det = share_of(uu, dd) - share_of(ud, ud)
    g = share_of(vd, ud) - share_of(uv, dd)
    b = share_of(uv, ud) - share_of(vd, uu)
    if g <= 0 or det < 0 or det >> TONE_SHIFT >= g or abs(b) >> TONE_SHIFT >= g:
        return 0

    def part(whole_sum: int, numerator: int) -> int:
        ratio = ((abs(numerator) >> TONE_SHIFT) << 32) // g
        made = share_of(whole_sum << (TONE_SHIFT + shift), ratio)
        return -made if numerator < 0 else made

    sum_v = z[-1] - z[-2] - z[1] + z[0]
    sum_d = z[-1] + z[-2] - z[1] - z[0]
    return part(sum_v, det) + part(sum_d, b)


def constant_q8(smooth: list[int]) -> int:
    """The constant under the tone, Q8."""
    inner = smooth[1:-1]
    over_count = (1 << 32) // len(inner)
    shift = max(0, (max(smooth) - min(smooth)).bit_length() - SPREAD_BITS)
    mean = share_of(sum(inner), over_count)
    z = [halved(value - mean, shift) for value in smooth]
    found = share_of((sum(inner) + tone_share(z, over_count, shift)) << 8, over_count)
    return min(max(found, min(smooth) << 8), max(smooth) << 8)


def weight(masses: list[int], base: int) -> int | None:
    """The weight of a stretch, `base` the first mass held; None where one is too far off it."""
    unit = max(0, base.bit_length() - 15)
    offs = [halved(mass - base, unit) for mass in masses]
    if max(map(abs, offs)) >= OFF_MAX:
        return None
    q8 = constant_q8(smoothed(offs))
    return base + (rounded_shift(q8, 8 - unit) if unit < 8 else q8 << (unit - 8))


class Checkweigher:
    """checkweigher.h; `config` has the fields of checkweigher_config_t."""

    def __init__(self, config: Mapping) -> None:
        if not is_lawful(config):
            raise ValueError("checkweigher.h refuses this configuration")
        self.config = config
        self.loaded = self.broken = False
        self.base = self.found = 0
        self.ring: deque[int] = deque(maxlen=SAMPLES_MAX)
        self.mass_mg = self.class_at = self.samples = self.unweighed = self.pending = 0
        self.counts = [0] * CLASSES_MAX
        self.last_us = self.entered_us = self.left_us = self.interval_us = 0

    def update(self, mass_mg: int, device_us: int) -> int:
        """Take one mass; gives the event."""
        elapsed_us, self.last_us = (device_us - self.last_us) % CLOCK_US, device_us
        verdict = self.pending == 1
        self.pending = max(0, self.pending - 1)
        if verdict:
            self._judge()
        event = self._follow(min(mass_mg, MASS_MAX), device_us, elapsed_us, may_end=not verdict)
        return VERDICT if verdict else event

    def interrupt(self) -> None:
        """checkweigher_interrupt."""
        self.broken = True

    def _follow(self, mass: int, device_us: int, elapsed_us: int, *, may_end: bool) -> int:
        if not self.loaded:
            if mass < self.config["enter_mg"]:
                return EMPTY
            self.loaded, self.broken, self.entered_us = True, False, device_us
            self.ring.clear()
        else:
            self.broken |= elapsed_us > self.config["gap_us"]
            if mass < self.config["leave_mg"]:
                return self._finish(device_us, elapsed_us) if may_end else LOADED
        since = (device_us - self.entered_us) % CLOCK_US
        if not self.pending and (self.ring or since >= self.config["settle_us"]):
            self.base = self.base if self.ring else mass
            self.ring.append(mass)
        return LOADED

    def _finish(self, device_us: int, elapsed_us: int) -> int:
        self.loaded = False
        self._pace(device_us)
        ages = (elapsed_us * (k + 1) for k in range(len(self.ring)))
        young = sum(age < self.config["tail_us"] for age in ages)
        self.samples = len(self.ring) - young
        whole = not self.broken and self.samples >= self.config["samples_min"]
        found = weight(list(self.ring)[: self.samples], self.base) if whole else None
        if found is None:
            self.unweighed = min(self.unweighed + 1, COUNTER_MAX)
            return UNWEIGHED
        self.found, self.pending = found, STEPS
        return EMPTY

    def _judge(self) -> None:
        self.mass_mg = self.found
        limits = self.config["limit_mg"][: self.config["classes"] - 1]
        self.class_at = sum(self.mass_mg >= limit for limit in limits)
        self.counts[self.class_at] += 1

    def _pace(self, device_us: int) -> None:
        elapsed_us = (device_us - self.left_us) % CLOCK_US
        self.left_us = device_us
        if self.weighed + self.unweighed == 0:
            return
        mean = self.interval_us
        self.interval_us = mean - (mean >> 3) + (elapsed_us >> 3) if mean else elapsed_us

    @property
    def weighed(self) -> int:
        return sum(self.counts)

    @property
    def per_minute_q8(self) -> int:
        if self.interval_us == 0 or self.interval_us > 1 << 31:
            return 0
        return min((60_000_000 << 8) // self.interval_us, 65535)
