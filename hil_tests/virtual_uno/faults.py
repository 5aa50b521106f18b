# SPDX-License-Identifier: GPL-3.0-or-later
"""Misbehaviour by the clock, so that a person can watch it, or by word."""

from __future__ import annotations

from dataclasses import dataclass, field

from virtual_uno import hx711
from virtual_uno.core_lib import ffi, lib
from virtual_uno.imu import BUS_FAULTS

UNPLUGGED = "imu_unplugged"
ON_THE_BUS = (*BUS_FAULTS, UNPLUGGED)
ONCE = ("bit_lost", "late", "glitch", "conversion_lost", "stretched")


class FaultError(ValueError):
    """It cannot be understood; the message is one line for a person."""


@dataclass(frozen=True)
class Misbehaviour:
    """A fault of ``hx711.FAULTS`` with its details, or one of ``ON_THE_BUS``."""

    name: str
    how: dict[str, float | str] = field(default_factory=dict)

    @classmethod
    def parse(cls, text: str) -> Misbehaviour:
        """From ``NAME[,detail=value]...``."""
        name, *details = (part.strip() for part in text.split(","))
        known = {} if name in ON_THE_BUS else hx711.FAULTS.get(name)
        if known is None:
            names = ", ".join([*hx711.FAULTS, *ON_THE_BUS])
            raise FaultError(f"no fault {name!r}; there are {names}")
        how = {}
        for detail in details:
            key, equals, value = detail.partition("=")
            if not equals or key not in known:
                raise FaultError(f"{name} has the details {', '.join(known) or 'none'}: {detail!r}")
            try:
                how[key] = type(known[key])(value)
            except ValueError:
                raise FaultError(f"{name}: {key} is no number: {value!r}") from None
        one = cls(name, how)
        _together([one])  # refuses what is out of range
        return one


@dataclass(frozen=True)
class Timed:
    """It holds from ``start_s`` until ``end_s``, None: for ever; those that come once have none."""

    what: Misbehaviour
    start_s: float
    end_s: float | None = None

    @classmethod
    def parse(cls, text: str) -> Timed:
        """From ``NAME[,detail=value]...@START[..END]``, seconds since reset."""
        what, at, when = text.rpartition("@")
        start, until, end = when.partition("..")
        try:
            start_s, end_s = float(start), float(end) if until else None
        except ValueError:
            start_s, end_s = -1.0, None
        if not at or start_s < 0 or (end_s is not None and end_s <= start_s):
            raise FaultError(f"{text!r} is not NAME[,detail=value]@START[..END] in seconds")
        return cls(Misbehaviour.parse(what), start_s, end_s)


def _together(faults):
    """All of them that are the converter's in one struct of the core."""
    raw = ffi.new("hx711_fault_t *")
    for one in faults:
        if one.name in ON_THE_BUS:
            continue
        try:
            hx711.apply_fault(raw, one.name, lib.UNO_CLOCK_HZ, **one.how)
        except (ValueError, KeyError, OverflowError) as error:
            raise FaultError(f"{one.name}: {error}") from None
    return raw


class FaultClock:
    """Makes a board misbehave at the times asked for; call ``look`` between its slices."""

    def __init__(self, uno, timed):
        self._uno = uno
        self._timed = sorted(timed, key=lambda one: one.start_s)
        self._by_word: list[Misbehaviour] = []
        self._on_the_bus: set[str] = set()
        self.restart()

    def restart(self):
        """The board was reset: seconds count from 0 again."""
        self._last_s = -1.0
        self._held: list[Misbehaviour] = []

    def look(self):
        """Begin and end what is due."""
        now_s = self._uno.seconds_since_reset
        held = list(self._by_word)
        once = []
        for one in self._timed:
            if one.what.name in ONCE:
                if self._last_s < one.start_s <= now_s:
                    once.append(one.what)
            elif one.start_s <= now_s and (one.end_s is None or now_s < one.end_s):
                held.append(one.what)
        self._last_s = now_s
        self._apply(held, once)

    def say(self, words):
        """``NAME[,detail=value]`` begins it, ``clear`` ends all that was begun by word."""
        words = words.strip()
        if words == "clear":
            self._by_word = []
        elif words:
            one = Misbehaviour.parse(words)
            if one.name in ONCE:
                self._apply(self._held, [one])
            else:
                self._by_word.append(one)

    def _apply(self, held, once):
        if held != self._held or once:
            lib.uno_fault(self._uno.core, _together([*held, *once]))
            self._held = held
        on_the_bus = {one.name for one in held if one.name in ON_THE_BUS}
        if on_the_bus != self._on_the_bus:
            self._apply_to_bus(on_the_bus)

    def _apply_to_bus(self, names):
        uno, before = self._uno, self._on_the_bus
        self._on_the_bus = names
        uno.bus.clear_faults()
        for name in names & set(BUS_FAULTS):
            uno.bus.fault(name)
        if UNPLUGGED in names - before:
            uno.imu.unplug()
        if UNPLUGGED in before - names:
            uno.imu.plug()
