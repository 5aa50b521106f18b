# SPDX-License-Identifier: MIT
"""Golden vectors of faults, from its exact twin."""

from __future__ import annotations

import random
from collections.abc import Iterator

from terazi.models.exact import COUNTS_MAX, COUNTS_MIN
from terazi.models.exact_faults import NOISE_COUNTS, Event, Faults
from tools.gen.golden import COUNTS, SEED, Draft

ORIGIN = "terazi.models.exact_faults, the contract of the header in unbounded integers"
PAUSE = 255
LOAD = 429_550  # 1 kg
Row = tuple[int, int]  # event, counts


def _run(rng: random.Random, count: int, load: float = LOAD, noise: float = 38.7) -> list[Row]:
    return [(Event.CONVERSION, round(rng.gauss(load, noise))) for _ in range(count)]


def _settling() -> list[Row]:
    return [(Event.DROPPED, 0)] * 4


def _broken(rng: random.Random) -> list[Row]:
    """Every fault that ends a run, each recovered from; also two at once, and a pause."""
    rows = _settling() + _run(rng, 8)
    for event in (Event.BAD_FRAME, Event.TIMED_OUT, Event.STUCK_LOW):
        rows += [(event, 0), *_settling(), *_run(rng, 6)]
    rows += [(Event.TIMED_OUT, 0)] * 3 + [(Event.STUCK_LOW, 0), (Event.BAD_FRAME, 0)]
    rows += _settling() + _run(rng, 2) + [(Event.OFF_BEAT, 5)] + _run(rng, 6)
    rows += [(Event.OFF_BEAT, 7)] * 4 + [(Event.NOTHING, 0)] + _run(rng, 6)
    rows += [(Event.DROPPED, 9)] * 3 + _run(rng, 6) + [(PAUSE, 0)] + _settling() + _run(rng, 6)
    return rows


def _railed(rng: random.Random) -> list[Row]:
    rails = [COUNTS_MAX, COUNTS_MAX - 1, COUNTS_MIN, COUNTS_MIN + 1, COUNTS_MAX]
    rows = _run(rng, 10)
    for rail in rails:
        rows += [(Event.CONVERSION, rail)] * rng.randint(1, 9) + _run(rng, rng.randint(2, 9))
    return rows + _run(rng, 10)


def _frozen(rng: random.Random) -> list[Row]:
    rows = _run(rng, 9)
    for count in (5, 6, 7, 40):
        rows += [(Event.CONVERSION, LOAD)] * count + _run(rng, 7)
    return rows + [(Event.CONVERSION, 0)] * 9 + [(Event.CONVERSION, -1)] * 9 + _run(rng, 5)


def _spikes(rng: random.Random) -> list[Row]:
    """Spikes of one and two conversions about every limit, also 2^k - 1; and a load step."""
    rows = _run(rng, 12, noise=4.0)
    heights = [512, 1790, 2047, 2048, 2304, 3100, 6000, 32_767, 200_000, (1 << 22) - 1 - LOAD]
    for height in heights:
        for width in (1, 2, 3):
            sign = rng.choice((-1, 1))
            rows += _run(rng, width, LOAD + sign * height, 4.0) + _run(rng, 14, noise=4.0)
    return rows + _run(rng, 20, 2 * LOAD) + _run(rng, 20, 0)


def _loud(rng: random.Random) -> list[Row]:
    """Noise about the limit and far beyond; loads that step, bounce and swing."""
    rows = _run(rng, 12)
    for noise in (1000.0, 4000.0, 8000.0, 40_000.0, 2e6):
        rows += _run(rng, 25, noise=noise) + _run(rng, 20)
    rows = [(event, min(max(counts, COUNTS_MIN + 1), COUNTS_MAX - 1)) for event, counts in rows]
    for count in (1, 2, 3, 5, 9):
        for n in range(count):
            rows += _run(rng, 3, LOAD * (n % 2 + 1))
        rows += _run(rng, 15)
    swing = [21_000, 21_000, -21_000, -21_000] * 10
    return rows + [(Event.CONVERSION, LOAD + at) for at in swing] + _run(rng, 15)


def _quiet(rng: random.Random) -> list[Row]:
    """The least limit: an HX711's own noise is too much."""
    return _run(rng, 30, noise=3.0) + _run(rng, 30, noise=5000.0) + _run(rng, 30, noise=0.4)


def _anything(rng: random.Random) -> list[Row]:
    events = [Event.CONVERSION] * 12 + list(Event)[1:] + [PAUSE]
    levels = [0, LOAD, COUNTS_MAX, COUNTS_MIN, LOAD + 1500]
    rows = []
    for _ in range(250):
        event, count = rng.choice(events), rng.choice((1, 1, 1, 2, 6, 11))
        if event == Event.CONVERSION:
            load, noise = rng.choice(levels), rng.choice((0.0, 5.0, 39.0, 39.0, 50_000.0))
            part = _run(rng, count, load, noise)
            rows += [(e, min(max(counts, COUNTS_MIN), COUNTS_MAX)) for e, counts in part]
        else:
            rows += [(event, rng.randint(COUNTS_MIN, COUNTS_MAX))] * min(count, 3)
    return rows


LIMITS = {"quiet": 0, "spikes": 65_535}  # noise_counts; else as faults.toml has it
STORIES = {
    "broken": ("runs that end in every way, and pauses", _broken),
    "railed": ("both rails, and one count beside them", _railed),
    "frozen": ("counts that repeat for shorter and longer than is allowed", _frozen),
    "spikes": ("spikes about every limit, and load steps", _spikes),
    "loud": ("noise about the limit; loads that step, bounce and swing", _loud),
    "quiet": ("the least limit of noise", _quiet),
    "anything": ("all events at random", _anything),
}


def played(rows: list[Row], noise_counts: int) -> tuple[list[tuple[int, ...]], Faults]:
    """Rows with what the twin says after each, and the twin as they left it."""
    twin, told = Faults(), []
    twin.limit_noise(noise_counts)
    for event, counts in rows:
        answer = 0
        if event == PAUSE:
            twin.pause()
        else:
            answer = twin.update(event, counts)
        told.append((int(event), counts, answer, int(twin.held)))
    return told, twin


def drafts() -> Iterator[Draft]:
    """All stories."""
    for at, (name, (shows, story)) in enumerate(STORIES.items()):
        seed = SEED + 70 + at
        noise_counts = LIMITS.get(name, NOISE_COUNTS)
        told, twin = played(story(random.Random(seed)), noise_counts)
        yield Draft(
            f"faults_{name}",
            f"faults: {shows}",
            {
                "event": f"faults_event_t; {PAUSE}: faults_pause",
                "counts": COUNTS,
                "answer": "FAULTS_CHANGED, SPOILT, RESTART as bits",
                "held": "bits of faults",
            },
            told,
            origin=ORIGIN,
            seed=str(seed),
            parameters={
                "noise_counts": str(noise_counts),
                "final_seen": str(int(twin.seen)),
            },
        )
