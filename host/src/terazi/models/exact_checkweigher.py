# SPDX-License-Identifier: MIT
"""Twin of checkweigher.h in Python's unbounded integers, straight from its contract."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

from terazi.models.exact import COUNTER_MAX, rounded_shift

MASS_MAX, OFF_MAX = 1 << 30, 1 << 14
CLASSES_MAX, SAMPLES_MIN, SAMPLES_MAX = 8, 12, 32
HELD_MAX = 255
MINUTE_32US_OVER_256 = 60_000_000 // (32 * 256)
CLOCK_US = 1 << 32
EMPTY, LOADED, VERDICT, UNWEIGHED = range(4)
STEPS = 2
SPREAD_BITS, TONE_SHIFT = 12, 4


def is_lawful(config: Mapping) -> bool:
    """What checkweigher_init answers."""
    if not 1 <= config["classes"] <= CLASSES_MAX:
        return False
    limits = config["limit_mg"][: config["classes"] - 1]
    rising = all(low < high for low, high in pairwise(limits))
    return (
        rising
        and 0 < config["leave_mg"] < config["enter_mg"]
        and SAMPLES_MIN <= config["samples_min"] <= SAMPLES_MAX
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
    exact = moments(z, over_count)
    any_bits = 0
    for each in exact:
        any_bits |= abs(each)
    down = max(0, any_bits.bit_length() - 15)
    uu, uv, ud, vd, dd = (each >> down for each in exact)
    det, g, b = uu * dd - ud * ud, vd * ud - uv * dd, uv * ud - vd * uu
    if det < 0 or g <= det >> TONE_SHIFT:
        return 0
    sum_v = z[-1] - z[-2] - z[1] + z[0]
    sum_d = z[-1] + z[-2] - z[1] - z[0]
    top = share_of(sum_v << 16, det) + share_of(sum_d << 16, b)
    if abs(top) >= g:
        return 0
    share = ((abs(top) << 32) // g) >> (16 - shift)
    return -share if top < 0 else share


def constant_q8(smooth: list[int]) -> int:
    """The constant under the tone, Q8."""
    inner = smooth[1:-1]
    over_count = (1 << 32) // len(inner)
    shift = max(0, (max(smooth) - min(smooth)).bit_length() - SPREAD_BITS)
    mean = share_of(sum(inner), over_count)
    z = [halved(value - mean, shift) for value in smooth]
    found = share_of((sum(inner) + tone_share(z, over_count, shift)) << 8, over_count)
    return min(max(found, min(smooth) << 8), max(smooth) << 8)


def weight(masses: list[int]) -> int | None:
    """The weight of a stretch; None where one is too far off the first."""
    base = masses[0]
    unit = max(0, base.bit_length() - 14)
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
        self.found = 0
        self.held: list[int] = []
        self.mass_mg = self.class_at = self.samples = self.unweighed = self.pending = 0
        self.counts = [0] * CLASSES_MAX
        self.last_us = self.entered_us = self.left_us = self.interval_32us = 0

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
            self.held = []
        else:
            self.broken |= elapsed_us > self.config["gap_us"]
            if mass < self.config["leave_mg"]:
                return self._finish(device_us, elapsed_us) if may_end else LOADED
        since = (device_us - self.entered_us) % CLOCK_US
        if not self.pending and (self.held or since >= self.config["settle_us"]):
            self.held = [*self.held, mass][:HELD_MAX]
        return LOADED

    def _finish(self, device_us: int, elapsed_us: int) -> int:
        self.loaded = False
        self._pace(device_us)
        ages = (elapsed_us * (k + 1) for k in range(len(self.held)))
        young = sum(age < self.config["tail_us"] for age in ages)
        self.samples = min(len(self.held) - young, SAMPLES_MAX)
        whole = not self.broken and self.samples >= self.config["samples_min"]
        found = weight(self.held[: self.samples]) if whole else None
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
        elapsed_256us = (device_us - self.left_us) % CLOCK_US >> 8
        self.left_us = device_us
        if self.weighed + self.unweighed == 0:
            return
        mean = self.interval_32us
        self.interval_32us = mean - (mean >> 3) + elapsed_256us if mean else elapsed_256us << 3

    @property
    def weighed(self) -> int:
        return sum(self.counts)

    @property
    def per_minute_q8(self) -> int:
        if self.interval_32us == 0:
            return 0
        return min((MINUTE_32US_OVER_256 << 16) // self.interval_32us, 65535)
