# SPDX-License-Identifier: MIT
"""Random lives of a converter on a scale, as its driver tells them: loads, noise, and what fails.

A story is what the driver and the measured rate say of each conversion; the driver itself and its
times are judged on the virtual Uno. Seeded; loads step, noise is an HX711's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from terazi.models.exact import COUNTS_MAX, COUNTS_MIN
from terazi.models.exact_faults import Event, Fault

COUNTS_PER_G = 1_000_000 / 2328
NOISE = {80: 38.7, 10: 21.5}  # HX711 datasheet p. 3
SETTLING_ERROR = (0.50, 0.12, 0.03, 0.01)  # of the way from where a start begins
START_COUNTS = 1 << 21
SETTLING = 4
LEARN = 16  # conversions off the beat until the firmware takes their rate for the new one
TIMEOUT_FIRST_S, TIMEOUT_LOW_S = 0.6, 0.12
NOISE_FAULT = 4000.0  # counts rms: less is no fault, and the scale's own business
WHOLE_24 = (1 << 24) - 1


@dataclass
class Story:
    """Events with what came with them and the truth; columns of one length."""

    events: np.ndarray
    counts: np.ndarray
    device_us: np.ndarray
    load_mg: np.ndarray
    episodes: list[Episode]


@dataclass(frozen=True)
class Episode:
    """One fault: rows begin to end, the latter not included."""

    kind: str
    begin: int
    end: int


@dataclass
class _Teller:
    rng: np.random.Generator
    rate_sps: float
    us: float = 0.0
    load_g: float = 0.0
    told: int = 0
    parts: list[tuple[np.ndarray, ...]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.sigma = NOISE[80 if self.rate_sps > 40 else 10]
        self.period_us = 1e6 / self.rate_sps

    def measure(self, count: int, extra: float = 0.0) -> np.ndarray:
        noise = np.hypot(self.sigma, extra)
        values = self.rng.normal(self.load_g * COUNTS_PER_G, noise, count)
        return np.clip(np.round(values), COUNTS_MIN, COUNTS_MAX).astype(np.int64)

    def tell(self, event: Event, counts: np.ndarray | int = 0, after_us: float = 0.0) -> None:
        """As many as there are counts, a period from one to the next if nothing else is said."""
        counts = np.atleast_1d(counts)
        times = self.us + (after_us or self.period_us) * np.arange(1, len(counts) + 1)
        self.us = times[-1]
        self.told += len(counts)
        events, loads = np.full(len(counts), int(event)), np.full(len(counts), self.load_g)
        self.parts.append((events, counts, np.round(times).astype(np.int64), loads))

    def convert(self, count: int, extra: float = 0.0) -> None:
        if count:
            self.tell(Event.CONVERSION, self.measure(count, extra))

    def drop(self, count: int = SETTLING) -> None:
        self.tell(Event.DROPPED, self.measure(count))

    def move_load(self) -> None:
        kind = self.rng.random()
        if kind < 0.3:
            self.load_g = 0.0
        elif kind < 0.5:
            self.load_g += self.rng.uniform(-30, 30)
        else:
            self.load_g = self.rng.uniform(5, 4500)
        self.load_g = float(np.clip(self.load_g, 0, 4500))


# --- what fails; each leaves the converter well again ---


def _perhaps_move(t: _Teller) -> None:
    if t.rng.random() < 0.5:
        t.move_load()


def _cable_out(t: _Teller) -> None:
    t.tell(Event.TIMED_OUT, after_us=2.25 * t.period_us)
    for _ in range(t.rng.integers(0, 4)):
        t.tell(Event.TIMED_OUT, after_us=TIMEOUT_FIRST_S * 1e6)
    _perhaps_move(t)
    t.drop()


def _loose_contact(t: _Teller) -> None:
    t.tell(Event.OFF_BEAT, t.measure(1), after_us=t.period_us * t.rng.uniform(1.02, 2.0))
    t.drop(SETTLING - 1)


def _settle_openly(t: _Teller) -> None:
    """The chip starts anew just on its beat: nobody drops what settles."""
    values = t.measure(SETTLING)
    start = START_COUNTS * t.rng.choice((1, 1, -1))
    t.tell(Event.CONVERSION, np.round(values + (start - values) * SETTLING_ERROR).astype(int))


def _stuck_low(t: _Teller) -> None:
    t.tell(Event.STUCK_LOW)
    for _ in range(t.rng.integers(0, 9)):
        t.tell(Event.STUCK_LOW, after_us=TIMEOUT_LOW_S * 1e6)
    _perhaps_move(t)
    t.drop()


def _bad_frame(t: _Teller) -> None:
    t.tell(Event.BAD_FRAME)
    t.drop()


def _rail(t: _Teller) -> None:
    rail = COUNTS_MAX if t.rng.random() < 0.5 else COUNTS_MIN
    t.tell(Event.CONVERSION, np.full(t.rng.integers(1, 120), rail))
    _perhaps_move(t)


def _rate(t: _Teller) -> None:
    usual_us, new_us = t.period_us, t.period_us * t.rng.choice((0.3, 0.8, 1.1, 2.1))
    for period_us in (new_us, usual_us):
        t.period_us = period_us
        t.tell(Event.OFF_BEAT, t.measure(LEARN))
        t.drop(SETTLING - 1)
        t.convert(int(t.rng.integers(0, 60)) if period_us == new_us else 0)


def _lost(t: _Teller) -> None:
    t.tell(Event.OFF_BEAT, t.measure(1), after_us=t.period_us * t.rng.integers(2, 4))
    t.drop(SETTLING - 1)


def _noise(t: _Teller) -> None:
    t.convert(int(t.rng.integers(2, 200)), NOISE_FAULT * 10 ** t.rng.uniform(0, 2.7))


def _signed(words: np.ndarray) -> np.ndarray:
    words = words & WHOLE_24
    return np.where(words & 1 << 23, words - (1 << 24), words)


def _flips(t: _Teller) -> None:
    probability, count = 10 ** t.rng.uniform(-3, -1), int(t.rng.integers(5, 200))
    flips = (t.rng.random((count, 24)) < probability) @ (1 << np.arange(24))
    t.tell(Event.CONVERSION, _signed(t.measure(count) ^ flips))


def _frozen(t: _Teller) -> None:
    """Also in mid-swing, and the load may change meanwhile."""
    value = t.measure(1, extra=t.rng.choice((0.0, 0.0, 3000.0)))
    for _ in range(2):
        t.tell(Event.CONVERSION, np.repeat(value, t.rng.integers(1, 100)))
        _perhaps_move(t)


def _spike(t: _Teller) -> None:
    """Ones behind some bit, as of a stretched pulse; a bit twice, as of a lost one; anything."""
    count = int(t.rng.integers(1, 3))
    words, ones = t.measure(count) & WHOLE_24, (1 << t.rng.integers(1, 24, count)) - 1
    shifted = (words & ~ones) | (words & ones) >> 1
    wrong = (words | ones, shifted, t.rng.integers(0, WHOLE_24, count))
    t.tell(Event.CONVERSION, _signed(wrong[t.rng.integers(3)]))


TELLERS: dict[str, Callable[[_Teller], None]] = {
    "cable_out": _cable_out,
    "loose_contact": _loose_contact,
    "settle_openly": _settle_openly,
    "dout_low": _stuck_low,
    "bad_frame": _bad_frame,
    "rail": _rail,
    "rate": _rate,
    "lost": _lost,
    "noise": _noise,
    "flips": _flips,
    "frozen": _frozen,
    "spike": _spike,
}
KINDS = tuple(TELLERS)
NAMED: dict[str, Fault] = {  # where the episode is plain enough to have one name
    "cable_out": Fault.CABLE_OUT,
    "loose_contact": Fault.FRAMES_LOST,
    "dout_low": Fault.DOUT_STUCK,
    "bad_frame": Fault.FRAMES_LOST,
    "rail": Fault.AT_RAIL,
    "rate": Fault.RATE,
    "lost": Fault.FRAMES_LOST,
}


def story(samples: int, *, rate_sps: float, seed: int) -> Story:
    """A life of about so many events: a fault every second or so, other loads as often."""
    teller = _Teller(np.random.default_rng(seed), rate_sps)
    teller.us = float(teller.rng.integers(0, 1 << 32))  # the clock wraps anywhere
    teller.drop()
    episodes = []
    while teller.told < samples:
        teller.convert(int(teller.rng.integers(1, 160)))
        if teller.rng.random() < 0.3:
            teller.move_load()
            continue
        kind = KINDS[teller.rng.integers(len(KINDS))]
        begin = teller.told
        TELLERS[kind](teller)
        episodes.append(Episode(kind, begin, teller.told))
    events, counts, times, load_g = (
        np.concatenate(part) for part in zip(*teller.parts, strict=True)
    )
    device_us = (times % (1 << 32)).astype(np.uint32)
    return Story(
        events.astype(np.uint8), counts.astype(np.int32), device_us, load_g * 1000.0, episodes
    )


def wrong_by_mg(mass_mg: np.ndarray, load_mg: np.ndarray, lag: int) -> np.ndarray:
    """How far masses lie outside all loads of the last `lag` rows: a filter is in between."""
    padded = np.concatenate([np.full(lag - 1, load_mg[0]), load_mg])
    seen = np.lib.stride_tricks.sliding_window_view(padded, lag)
    low, high = seen.min(axis=1), seen.max(axis=1)
    return np.maximum(np.maximum(low - mass_mg, mass_mg - high), 0.0)
