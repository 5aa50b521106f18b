# SPDX-License-Identifier: MIT
"""Twin of scale.h in Python's unbounded integers, straight from its contract."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import IntEnum, IntFlag
from itertools import pairwise

from terazi.models.exact import COUNTER_MAX, rounded_shift

BITS_31 = range(-1 << 30, 1 << 30)  # counts Q7 and masses
COUNTS_MAX = BITS_31[-1]
POINT_MASS_MAX = MAX_MAX = 1 << 29
POINTS_MAX, DECIMALS_MAX = 8, 6
TIME_MAX_US = 1 << 31
CLOCK_US = 1 << 32
TRACK_US = 1 << 18
APART, LEAP_MAX = range(-1 << 11, 1 << 11), (1 << 12) - 1  # grains
INITIAL_ZERO, TRACK_ZERO = 1, 2
LIVE, HELD, PEAK = range(3)


class Flag(IntFlag):
    """Bits of scale_update's answer."""

    STABLE = 1
    AT_ZERO = 2
    OVER = 4
    UNDER = 8
    STEPPED = 16
    ZEROED = 32
    TARED = 64
    FROZEN = 128


class Status(IntEnum):
    """scale_status_t."""

    OK = 0
    BAD_COUNT = 1
    BAD_POINT = 2
    NOT_MONOTONE = 3
    TOO_STEEP = 4
    BAD_RANGE = 5
    BAD_DIVISION = 6
    BAD_TIME = 7
    NOT_STABLE = 8
    OUT_OF_RANGE = 9
    TOO_LIGHT = 10
    UNKNOWN = 11


def in_31_bits(value: int) -> int:
    return min(max(value, BITS_31[0]), BITS_31[-1])


def limit(value: int, bound: int) -> int:
    return min(max(value, -bound), bound)


def per_division(
    config: Mapping, reciprocals: Sequence[tuple[int, int]]
) -> tuple[int, bool] | None:
    """(1/d in 1/mg, whether it is in Q32 and not in Q40), None where the display is unlawful."""
    if config["digit"] not in (1, 2, 5) or config["decimals"] > DECIMALS_MAX:
        return None
    if config["unit"] >= len(reciprocals) or config["hysteresis_q8"] > 127:
        return None
    mantissa, exponent = reciprocals[config["unit"]]
    factor = 10 ** config["decimals"] * (10 // config["digit"]) << 64 - exponent
    if factor < 1 << 24:
        return rounded_shift(mantissa * factor, 24), False
    over_mg = config["max_mg"] + 9 * config["interval_mg"]
    if factor >= 1 << 32 or over_mg >= 1 << 23:
        return None
    return rounded_shift(mantissa * factor, 32), True


def band_grains(band_mg: int, steepest_q32: int) -> tuple[int, int]:
    """(the band in grains, binary digits of a grain of counts Q7)."""
    half, grain = steepest_q32 // 2, 0  # the band is band_mg * 2^31 / half
    while (band_mg << 31) // (half << grain) > 255:
        grain += 1
    return (band_mg << 31) // (half << grain) - (grain > 0), grain


def judge(config: Mapping, reciprocals: Sequence[tuple[int, int]]) -> Status:
    """What scale_init answers."""
    count, max_mg, e_mg = config["points"], config["max_mg"], config["interval_mg"]
    if not 2 <= count <= POINTS_MAX:
        return Status.BAD_COUNT
    counts, masses = config["point_counts_q7"][:count], config["point_mass_mg"][:count]
    sign = -1 if counts[1] < counts[0] else 1
    for at in range(count):
        if counts[at] not in BITS_31 or abs(masses[at]) > POINT_MASS_MAX:
            return Status.BAD_POINT
        if at == 0:
            continue
        run, rise = sign * (counts[at] - counts[at - 1]), masses[at] - masses[at - 1]
        if run <= 0 or rise <= 0:
            return Status.NOT_MONOTONE
        if rise >= run:
            return Status.TOO_STEEP
    if not (1 <= max_mg <= MAX_MAX and 1 <= e_mg <= max_mg // 16):
        return Status.BAD_RANGE
    if not (0 <= config["under_mg"] <= max_mg and 0 <= config["step_mg"] <= max_mg):
        return Status.BAD_RANGE
    if not 0 <= config["stable_band_mg"] <= e_mg // 2:
        return Status.BAD_RANGE
    if not all(1 <= config[key] <= TIME_MAX_US for key in ("stable_us", "gap_us")):
        return Status.BAD_TIME
    if per_division(config, reciprocals) is None:
        return Status.BAD_DIVISION
    return Status.OK


class Scale:
    """scale.h; `config` has the fields of scale_config_t."""

    def __init__(self, config: Mapping, reciprocals: Sequence[tuple[int, int]]) -> None:
        status = judge(config, reciprocals)
        if status != Status.OK:
            raise ValueError(f"scale.h refuses this configuration: {status.name}")
        self.config = config
        self.per_division, self.fine = per_division(config, reciprocals)
        count = config["points"]
        counts = config["point_counts_q7"][:count]
        self.sign = -1 if counts[1] < counts[0] else 1
        self.points = list(
            zip((self.sign * c for c in counts), config["point_mass_mg"][:count], strict=True)
        )
        self.zero_range_mg = (config["max_mg"] + 25) // 50
        self.initial_mg = self.zero_mg = self.tare_mg = 0
        self.mass_mg = self.net_mg = self.kept_mg = 0
        steepest_q32 = max(
            ((m1 - m0) << 32) // (x1 - x0) for (x0, m0), (x1, m1) in pairwise(self.points)
        )
        self.band, self.grain = band_grains(config["stable_band_mg"], steepest_q32)
        self.anchor_q7 = self.low = self.high = 0  # of the band, since since_us; in grains
        self.raw = self.rough_q4 = self.lag_q3 = 0
        self.since_us = self.last_us = 0
        self.begun, self.steady, self.settled_mg = False, False, None
        self.step_us = self.step_from_mg = self.step_to_mg = self.steps = 0
        self.divisions, self.show_what, self.per_piece_q32 = 0, LIVE, 0
        self.flags = Flag(0)

    def mass(self, counts_q7: int) -> int:
        """Mass by the calibration alone."""
        x = self.sign * in_31_bits(counts_q7)
        at = max([n for n, (point, _) in enumerate(self.points[:-1]) if point <= x], default=0)
        (x0, m0), (x1, m1) = self.points[at : at + 2]
        slope_q32 = ((m1 - m0) << 32) // (x1 - x0)
        risen = rounded_shift(abs(x - x0) * slope_q32, 32)
        return in_31_bits(m0 + risen if x >= x0 else m0 - risen)

    @property
    def load_mg(self) -> int:
        return self.mass_mg - self.zero_mg

    def _grains(self, counts_q7: int) -> int:
        """From where the band began; the difference comes round modulo 2^32."""
        apart = (counts_q7 - self.anchor_q7 + CLOCK_US // 2) % CLOCK_US - CLOCK_US // 2
        return apart >> self.grain

    def _stands(self, counts_q7: int, raw_q7: int) -> bool:
        """port_watch.h; all in grains."""
        at, raw = (
            min(max(self._grains(each), APART[0]), APART[-1]) for each in (counts_q7, raw_q7)
        )
        band, rough = self.band, self.rough_q4 // 16
        wide, reach = max(band, rough), band + max(band - band // 4, 4 * rough)
        stood_us = (self.last_us - self.since_us) % CLOCK_US
        early = not self.steady and stood_us < self.config["stable_us"] // 4
        leap = abs(raw - self.raw) if self._grains(raw_q7) in APART else LEAP_MAX
        self.rough_q4 += min(leap, rough + rough // 2 + 4) - rough
        self.raw = raw
        self.lag_q3 += limit(raw - at, wide) - self.lag_q3 // 8
        self.low, self.high = min(self.low, at), max(self.high, at)
        allowed = band + band // 2 if self.steady else band // 2 if early else band
        beyond = max(raw - self.low, self.high - raw) > reach
        behind = not early and abs(self.lag_q3) > 4 * wide
        if self.begun and self.high - self.low <= allowed and not (beyond or behind):
            return True
        self.low, self.high, self.raw = 0, 0, raw - at
        return False

    def resume(self, zero_mg: int, tare_mg: int, firm: bool) -> None:
        """A zero and a tare of before; firm: no initial zero."""
        if abs(zero_mg) <= 6 * self.zero_range_mg:
            self.initial_mg = self.zero_mg = zero_mg
        self.flags = Flag.ZEROED if firm else Flag(0)
        if 0 < tare_mg <= self.config["max_mg"]:
            self.tare_mg = tare_mg
            self.flags |= Flag.TARED

    def interrupt(self) -> None:
        """Samples were lost."""
        if self.steady:
            self.step_us, self.settled_mg = self.last_us, self.mass_mg
        self.steady = self.begun = False
        self.flags &= ~Flag.STABLE

    def _watch(self, counts_q7: int, raw_q7: int) -> None:
        """Whether the load stands, then its mass, and what follows from both."""
        if not self._stands(counts_q7, raw_q7):
            self.interrupt()
            self.begun, self.anchor_q7, self.since_us = True, counts_q7, self.last_us
        self.mass_mg = self.mass(counts_q7)
        stood_us = (self.last_us - self.since_us) % CLOCK_US
        if self.steady:
            if stood_us >= TRACK_US:
                self._track()
        elif stood_us >= self.config["stable_us"]:
            self._settle()

    def _settle(self) -> None:
        self.steady = True
        self.since_us = self.last_us
        if self.settled_mg is None:
            near = abs(self.mass_mg) <= 5 * self.zero_range_mg
            if self.config["options"] & INITIAL_ZERO and near and not self.flags & Flag.ZEROED:
                self.initial_mg = self.mass_mg
                self._set_zero()
        elif abs(self.mass_mg - self.settled_mg) > self.config["step_mg"]:
            self.step_from_mg = self.settled_mg - self.zero_mg
            self.step_to_mg = self.load_mg
            self.steps = min(self.steps + 1, COUNTER_MAX)
            self.flags |= Flag.STEPPED
        self.settled_mg = self.mass_mg

    def _set_zero(self) -> None:
        self.zero_mg = self.mass_mg
        self.flags |= Flag.ZEROED

    def _track(self) -> None:
        e = self.config["interval_mg"]
        self.since_us = self.last_us
        if self.config["options"] & TRACK_ZERO and abs(self.load_mg) <= e // 2:
            wanted = self.zero_mg + limit(self.load_mg, e // 8)
            if abs(wanted - self.initial_mg) <= self.zero_range_mg:
                self.zero_mg = wanted

    def update(self, counts_q7: int, device_us: int, raw_q7: int | None = None) -> Flag:
        """Take one estimate; raw_q7: what was measured with it, before any filter."""
        if (device_us - self.last_us) % CLOCK_US > self.config["gap_us"]:
            self.begun = False
        self.last_us = device_us
        self.flags &= Flag.ZEROED | Flag.TARED | Flag.FROZEN
        self._watch(counts_q7, counts_q7 if raw_q7 is None else raw_q7)
        self.net_mg = self.load_mg - self.tare_mg
        if self.show_what == PEAK:
            self.kept_mg = max(self.net_mg, self.kept_mg)
        load, e = self.load_mg, self.config["interval_mg"]
        if load > self.config["max_mg"] + 9 * e:
            self.flags |= Flag.OVER
        elif load < -self.config["under_mg"]:
            self.flags |= Flag.UNDER
        else:
            self.flags |= Flag.STABLE if self.steady else Flag(0)
            self.flags |= Flag.AT_ZERO if abs(load) <= e // 4 else Flag(0)
        return self.flags

    def zero(self) -> Status:
        if Flag.STABLE not in self.flags:
            return Status.NOT_STABLE
        if abs(self.mass_mg - self.initial_mg) > self.zero_range_mg:
            return Status.OUT_OF_RANGE
        self._set_zero()
        return Status.OK

    def tare(self) -> Status:
        if Flag.STABLE not in self.flags:
            return Status.NOT_STABLE
        if not 0 < self.load_mg <= self.config["max_mg"]:
            return Status.OUT_OF_RANGE
        self.tare_mg = self.load_mg
        self.flags |= Flag.TARED
        return Status.OK

    def tare_clear(self) -> None:
        self.tare_mg = 0
        self.flags &= ~Flag.TARED

    def show(self, what: int) -> Status:
        if what not in (LIVE, HELD, PEAK):
            return Status.UNKNOWN
        self.show_what, self.kept_mg = what, self.net_mg
        self.flags = self.flags & ~Flag.FROZEN | (Flag.FROZEN if what else Flag(0))
        return Status.OK

    def count_out(self, pieces: int) -> Status:
        if pieces == 0:
            return Status.UNKNOWN
        if Flag.STABLE not in self.flags:
            return Status.NOT_STABLE
        if self.net_mg < max(20 * self.config["interval_mg"], 2 * pieces):
            return Status.TOO_LIGHT
        self.per_piece_q32 = (pieces << 32) // self.net_mg
        return Status.OK

    @property
    def pieces(self) -> int:
        size = rounded_shift(abs(self.net_mg) * self.per_piece_q32, 32)
        return -size if self.net_mg < 0 else size

    @property
    def shown(self) -> int:
        """Of what is shown from now on."""
        mass_mg = self.net_mg if self.show_what == LIVE else self.kept_mg
        size = abs(mass_mg)
        if self.fine:
            size = min(size << 8, 0x7FFFFF00)
        exact_q8 = rounded_shift(size * self.per_division, 32)
        if mass_mg < 0:
            exact_q8 = -exact_q8
        if abs(exact_q8 - 256 * self.divisions) > 128 + self.config["hysteresis_q8"]:
            self.divisions = rounded_shift(exact_q8, 8)
        return self.divisions * self.config["digit"]
