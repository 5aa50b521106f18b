# SPDX-License-Identifier: MIT
"""Golden vectors of scale, from its exact twin."""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator

from terazi.design import scale as design
from terazi.models import exact_scale
from tools.gen.golden import COUNTS_Q7, SEED, Draft

ORIGIN = "terazi.models.exact_scale, the contract of the header in unbounded integers"
SAMPLE, ZERO, TARE, TARE_CLEAR, SHOW, COUNT_OUT, INTERRUPT = range(7)
PERIOD_US = 12_500
G_Q7 = 1_000_000 * 128 // 2328  # counts Q7 a gram of the nominal cell
Row = tuple[int, int, int, int, int]  # command, argument, raw, counts, time
CORNERS = {  # every field at a bound of scale.h
    "point_counts_q7": [(1 << 30) - 1, 50, 48, 40, 4, 0, -1 << 29, -1 << 30],
    "point_mass_mg": [-1 << 29, -300, -299, -298, -297, -296, 1, (1 << 29) - 2],
    "max_mg": 1 << 29,
    "interval_mg": 1 << 25,
    "under_mg": 1 << 29,
    "step_mg": 0,
    "stable_band_mg": 1 << 24,
    "stable_us": 1,
    "gap_us": 1 << 31,
    "points": 8,
    "unit": 1,
    "decimals": 0,
    "digit": 5,
    "hysteresis_q8": 127,
    "options": 3,
}


def bowed_points(count: int, *, bow: float = 2e-4, max_g: float = 5000.0, sign: int = 1):
    """(counts, gram) of a cell whose counts bow by `bow` of Max above the straight line."""
    span = sign * design.default_points()[1][0]
    shares = [n / (count - 1) for n in range(count)]
    return [(span * (s + 4 * bow * s * (1 - s)), s * max_g) for s in shares]


class _Stream:
    """Samples of an 80 SPS converter, in noise, with commands between them."""

    def __init__(self, rng: random.Random, start_us: int = 0) -> None:
        self.rng, self.us = rng, start_us
        self.rows: list[Row] = []

    def stand(self, grams: float, count: int, noise: int = 900, drift_g: float = 0.0) -> None:
        for n in range(count):
            self.us = (self.us + PERIOD_US) % exact_scale.CLOCK_US
            level = round((grams + drift_g * n / count) * G_Q7)
            counts_q7 = level + self.rng.randint(-noise, noise)
            raw_q7 = level + self.rng.randint(-8 * noise, 8 * noise)
            self.rows.append((SAMPLE, 0, raw_q7, counts_q7, self.us))

    def command(self, command: int, argument: int = 0) -> None:
        self.rows.append((command, argument, 0, 0, 0))


def _day(rng: random.Random) -> list[Row]:
    """Everything once: also each refusal of a command."""
    s = _Stream(rng, start_us=exact_scale.CLOCK_US - 900_000)  # the clock wraps early on
    s.stand(12.3, 10)
    s.command(TARE)  # not stable
    s.stand(12.3, 60)
    s.command(TARE)  # nothing there
    s.command(COUNT_OUT, 4)  # too light
    s.stand(12.3, 120, drift_g=0.4)  # tracked
    s.stand(262.4, 60)
    s.command(ZERO)  # too far off
    s.command(SHOW, 3)  # unknown
    s.command(TARE)
    s.stand(412.4, 60)
    s.command(COUNT_OUT, 0)  # none
    s.command(COUNT_OUT, 30)
    s.stand(417.4, 60)
    s.command(SHOW, 1)
    s.stand(100.0, 30)
    s.command(SHOW, 2)
    s.stand(700.0, 30)
    s.stand(600.0, 30)
    s.command(SHOW, 0)
    s.stand(600.0, 30)
    s.command(TARE_CLEAR)
    s.stand(5030.0, 60)  # over
    s.command(TARE)  # not stable
    s.command(INTERRUPT)
    s.stand(-30.0, 60)  # under
    s.command(ZERO)  # not stable
    s.stand(62.3, 60)
    s.us += 300_000  # a gap
    s.command(ZERO)
    s.stand(62.3, 60, drift_g=1.0)
    return s.rows


def _wander(rng: random.Random, count: int) -> list[Row]:
    """Counts of full scale and beyond, at irregular times, now and then standing."""
    rows, us, counts = [], 0, 0
    for _ in range(count):
        us = (us + rng.choice((1, PERIOD_US, 100_000, 1 << 31, rng.randrange(1 << 32)))) % (1 << 32)
        if rng.random() < 0.6:
            counts = rng.choice((rng.randint(-(1 << 31), (1 << 31) - 1), rng.randint(-9, 9)))
        raw = counts if rng.random() < 0.5 else rng.randint(-(1 << 31), (1 << 31) - 1)
        rows.append((SAMPLE, 0, raw, counts, us))
        if rng.random() < 0.1:
            rows.append((rng.randrange(ZERO, INTERRUPT + 1), rng.choice((0, 1, 2, 65535)), 0, 0, 0))
    return rows


def _ramp(rng: random.Random, top_g: float, count: int = 90) -> list[Row]:
    """Up past the rounding's edges, then back."""
    s = _Stream(rng)
    for n in range(count):
        s.stand(top_g * (n if n < count // 2 else count - n) / (count // 2), 1)
    return s.rows


def play(twin: exact_scale.Scale, rows: Iterable[Row]) -> list[tuple[int, ...]]:
    """Rows with what the twin answers: flags or status, net mass, what is shown, pieces, mass."""
    played = []
    for command, argument, raw_q7, counts_q7, device_us in rows:
        if command == SAMPLE:
            answer = int(twin.update(counts_q7, device_us, raw_q7))
        elif command in (TARE_CLEAR, INTERRUPT):
            (twin.tare_clear if command == TARE_CLEAR else twin.interrupt)()
            answer = 0
        elif command in (SHOW, COUNT_OUT):
            answer = int((twin.show if command == SHOW else twin.count_out)(argument))
        else:
            answer = int((twin.zero if command == ZERO else twin.tare)())
        results = (twin.net_mg, twin.shown, twin.pieces, twin.mass(counts_q7))
        played.append((command, argument, raw_q7, counts_q7, device_us, answer, *results))
    return played


def _cases() -> Iterator[tuple[str, str, dict, list[Row]]]:
    rng = random.Random(SEED + 30)
    usual = design.config()
    yield "day", "zero, tracking, tare, pieces, hold, peak, limits, refusals", usual, _day(rng)
    bow = design.config(bowed_points(8), unit="kg", decimals=3, interval_g=0.5)
    yield "bow", "eight points of a bowed cell", bow, _ramp(rng, 5500.0)
    turned = design.config(bowed_points(5, sign=-1), options=[])
    yield (
        "turned",
        "counts that fall with mass",
        turned,
        [
            (command, argument, -raw, -counts, us)
            for command, argument, raw, counts, us in _ramp(rng, 5500.0)
        ],
    )
    yield (
        "corners",
        "a configuration at its bounds, counts beyond theirs",
        CORNERS,
        _wander(rng, 300),
    )
    fine = {"max_g": 200.0, "interval_g": 0.02}
    for unit, decimals, digit in (("g", 2, 1), ("kg", 5, 2), ("lb", 4, 5), ("oz", 3, 2)):
        config = design.config(unit=unit, decimals=decimals, digit=digit, **fine)
        yield f"unit_{unit}", f"{digit}e-{decimals} {unit} shown", config, _ramp(rng, 220.0)
    newton = design.config(unit="N", decimals=2, digit=1)
    yield "unit_n", "hundredths of a newton shown", newton, _ramp(rng, 5000.0)


def drafts() -> Iterator[Draft]:
    """All of scale's."""
    for name, shows, config, rows in _cases():
        twin = exact_scale.Scale(config, design.reciprocals(design.spec()))
        played = play(twin, rows)
        fields = {
            field: " ".join(map(str, value)) if isinstance(value, list) else str(value)
            for field, value in config.items()
        }
        outcome = ("steps", "step_us", "step_from_mg", "step_to_mg", "kept_mg")
        yield Draft(
            f"scale_{name}",
            f"scale: {shows}",
            {
                "command": "0 sample, 1 zero, 2 tare, 3 tare clear, 4 show, 5 count out, "
                "6 interrupt",
                "argument": "of show and count out",
                "raw": f"{COUNTS_Q7}, before any filter",
                "counts": COUNTS_Q7,
                "device_us": "us, uint32",
                "answer": "flags of a sample, else scale_status_t",
                "net_mg": "mg, int32",
                "shown": "in 10^-decimals of the unit",
                "pieces": "pieces, int32",
                "mass_mg": "mg, int32, of the row's counts by the calibration's curve alone",
            },
            played,
            origin=ORIGIN,
            seed=str(SEED + 30),
            parameters=fields | {f"final_{key}": str(getattr(twin, key)) for key in outcome},
        )
