# SPDX-License-Identifier: MIT
"""Twin of scale.h in Python's unbounded integers, straight from its contract."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import IntEnum, IntFlag

from terazi.models.exact import COUNTER_MAX, rounded_shift

COUNTS_MAX = MASS_MAX = 1 << 30
POINT_MASS_MAX = MAX_MAX = 500_000_000
POINTS_MAX, DECIMALS_MAX = 8, 6
TIME_MAX_US = 1 << 31
CLOCK_US = 1 << 32
TRACK_US = 1 << 17
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


def limit(value: int, bound: int) -> int:
    return min(max(value, -bound), bound)


def per_division(
    config: Mapping, reciprocals: Sequence[tuple[int, int]]
) -> tuple[int, bool] | None:
    """(1/d in 1/mg, whether it is in Q32 and not in Q40), None where the display is unlawful."""
    if config["digit"] not in (1, 2, 5) or config["decimals"] > DECIMALS_MAX:
        return None
    place = 3 * config["unit"] + (1, 2, 5).index(config["digit"])
    if place >= len(reciprocals) or config["hysteresis_q8"] > 127:
        return None
    mantissa, exponent = reciprocals[place]
    product = mantissa * 10 ** config["decimals"]
    coarse, fine = product >> exponent - 40, product >> exponent - 32
    if coarse < 1 << 32:
        return coarse, False
    over_mg = config["max_mg"] + 9 * config["interval_mg"]
    return (fine, True) if fine < 1 << 32 and over_mg < 1 << 23 else None


def judge(config: Mapping, reciprocals: Sequence[tuple[int, int]]) -> Status:
    """What scale_init answers."""
    count, max_mg, e_mg = config["points"], config["max_mg"], config["interval_mg"]
    if not 2 <= count <= POINTS_MAX:
        return Status.BAD_COUNT
    counts, masses = config["point_counts_q7"][:count], config["point_mass_mg"][:count]
    if max(map(abs, counts)) > COUNTS_MAX or max(map(abs, masses)) > POINT_MASS_MAX:
        return Status.BAD_POINT
    sign = -1 if counts[1] < counts[0] else 1
    for at in range(1, count):
        run, rise = sign * (counts[at] - counts[at - 1]), masses[at] - masses[at - 1]
        if run <= 0 or rise <= 0:
            return Status.NOT_MONOTONE
        if rise >= run:
            return Status.TOO_STEEP
    if not (1 <= max_mg <= MAX_MAX and 1 <= e_mg <= max_mg // 16):
        return Status.BAD_RANGE
    if not (0 <= config["under_mg"] <= max_mg and 0 <= config["step_mg"] <= max_mg):
        return Status.BAD_RANGE
    if not 0 <= config["stable_band_mg"] <= e_mg:
        return Status.BAD_RANGE
    if per_division(config, reciprocals) is None:
        return Status.BAD_DIVISION
    if not all(1 <= config[key] <= TIME_MAX_US for key in ("stable_us", "gap_us")):
        return Status.BAD_TIME
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
        self.initial_mg = self.zero_q4 = self.tare_mg = 0
        self.mass_mg = self.load_mg = self.net_mg = self.peak_mg = self.held_mg = 0
        self.band: list[int] = []  # lowest and highest since since_us
        self.since_us = self.last_us = self.left_us = self.tracking_us = 0
        self.steady, self.settled_mg = False, None
        self.step_us = self.step_from_mg = self.step_to_mg = self.steps = 0
        self.divisions, self.show_what, self.per_piece_q32 = 0, LIVE, 0
        self.flags = Flag(0)

    def mass(self, counts_q7: int) -> int:
        """Mass by the calibration alone."""
        x = self.sign * limit(counts_q7, COUNTS_MAX)
        at = max([n for n, (point, _) in enumerate(self.points[:-1]) if point <= x], default=0)
        (x0, m0), (x1, m1) = self.points[at : at + 2]
        slope_q32 = ((m1 - m0) << 32) // (x1 - x0)
        risen = rounded_shift(abs(x - x0) * slope_q32, 32)
        return limit(m0 + risen if x >= x0 else m0 - risen, MASS_MAX)

    @property
    def zero_mg(self) -> int:
        return rounded_shift(self.zero_q4, 4)

    def resume(self, zero_mg: int, tare_mg: int, firm: bool) -> None:
        """A zero and a tare of before; firm: no initial zero."""
        if abs(zero_mg) <= self.config["max_mg"] // 10 + self.config["max_mg"] // 50:
            self.initial_mg, self.zero_q4 = zero_mg, 16 * zero_mg
        self.flags = Flag.ZEROED if firm else Flag(0)
        if 0 < tare_mg <= self.config["max_mg"]:
            self.tare_mg = tare_mg
            self.flags |= Flag.TARED

    def interrupt(self) -> None:
        """Samples were lost."""
        self._unsettle(self.last_us)
        self.band = []
        self.flags &= ~Flag.STABLE

    def _unsettle(self, us: int) -> None:
        if self.steady:
            self.left_us = us
        self.steady, self.tracking_us = False, 0

    def _watch(self, us: int) -> None:
        mass = self.mass_mg
        wider = [min([*self.band, mass]), max([*self.band, mass])]
        if not self.band or wider[1] - wider[0] > self.config["stable_band_mg"]:
            self._unsettle(us)
            self.band, self.since_us = [mass, mass], us
        else:
            self.band = wider
            if not self.steady and (us - self.since_us) % CLOCK_US >= self.config["stable_us"]:
                self._settle()
        if self.steady:
            self.settled_mg = mass

    def _settle(self) -> None:
        self.steady = True
        if self.settled_mg is None:
            near = abs(self.mass_mg) <= self.config["max_mg"] // 10
            if self.config["options"] & INITIAL_ZERO and near and not self.flags & Flag.ZEROED:
                self.initial_mg = self.mass_mg
                self._set_zero()
        elif abs(self.mass_mg - self.settled_mg) > self.config["step_mg"]:
            self.step_us = self.left_us
            self.step_from_mg = self.settled_mg - self.zero_mg
            self.step_to_mg = self.mass_mg - self.zero_mg
            self.steps = min(self.steps + 1, COUNTER_MAX)
            self.flags |= Flag.STEPPED

    def _set_zero(self) -> None:
        self.zero_q4, self.tracking_us = 16 * self.mass_mg, 0
        self.flags |= Flag.ZEROED

    def _track(self, elapsed_us: int) -> None:
        e, load = self.config["interval_mg"], self.mass_mg - self.zero_mg
        if not self.config["options"] & TRACK_ZERO or abs(load) > e // 2:
            self.tracking_us = 0
            return
        self.tracking_us += elapsed_us
        if self.tracking_us < TRACK_US:
            return
        self.tracking_us = 0
        centre, span = 16 * self.initial_mg, 16 * (self.config["max_mg"] // 50)
        self.zero_q4 = centre + limit(self.zero_q4 + limit(16 * load, e) - centre, span)

    def _display(self, mass_mg: int) -> None:
        size = abs(mass_mg)
        if self.fine:
            size = min(size << 8, 0x7FFFFF00)
        exact_q8 = rounded_shift(size * self.per_division, 32)
        if mass_mg < 0:
            exact_q8 = -exact_q8
        if abs(exact_q8 - 256 * self.divisions) > 128 + self.config["hysteresis_q8"]:
            self.divisions = rounded_shift(exact_q8, 8)

    def update(self, counts_q7: int, device_us: int) -> Flag:
        """Take one estimate."""
        elapsed_us = (device_us - self.last_us) % CLOCK_US
        if elapsed_us > self.config["gap_us"]:
            self.interrupt()
        self.last_us = device_us
        self.mass_mg = self.mass(counts_q7)
        self.flags &= Flag.ZEROED | Flag.TARED | Flag.FROZEN
        was_steady = self.steady
        self._watch(device_us)
        if was_steady and self.steady:
            self._track(elapsed_us)
        self.load_mg = load = self.mass_mg - self.zero_mg
        self.net_mg = load - self.tare_mg
        self.peak_mg = max(self.peak_mg, self.net_mg)
        e = self.config["interval_mg"]
        if load > self.config["max_mg"] + 9 * e:
            self.flags |= Flag.OVER
        elif load < -self.config["under_mg"]:
            self.flags |= Flag.UNDER
        else:
            self.flags |= Flag.STABLE if self.steady else Flag(0)
            self.flags |= Flag.AT_ZERO if abs(load) <= e // 4 else Flag(0)
        self._display((self.net_mg, self.held_mg, self.peak_mg)[self.show_what])
        return self.flags

    def zero(self) -> Status:
        if Flag.STABLE not in self.flags:
            return Status.NOT_STABLE
        if abs(self.mass_mg - self.initial_mg) > self.config["max_mg"] // 50:
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
        self.show_what, self.held_mg = what, self.net_mg
        if what == PEAK:
            self.peak_mg = self.net_mg
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
        return self.divisions * self.config["digit"]
