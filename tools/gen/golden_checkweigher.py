# SPDX-License-Identifier: MIT
"""Golden vectors of checkweigher, from its exact twin."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator

from terazi.models import exact_checkweigher
from tools.gen.golden import SEED, Draft

ORIGIN = "terazi.models.exact_checkweigher, the contract of the header in unbounded integers"
PERIOD_US = 12_500
USUAL = {
    "limit_mg": [240_000, 260_000, 600_000, 0, 0, 0, 0],
    "enter_mg": 50_000,
    "leave_mg": 30_000,
    "settle_us": 65_000,
    "tail_us": 60_000,
    "gap_us": 20_000,
    "classes": 4,
    "samples_min": 12,
}
CORNERS = {
    "limit_mg": [-(1 << 31), -1, 0, 1, 1_000_000, 2_000_000, (1 << 31) - 1],
    "enter_mg": 2,
    "leave_mg": 1,
    "settle_us": 0,
    "tail_us": 0,
    "gap_us": 500_000,
    "classes": 8,
    "samples_min": 12,
}
Row = tuple[int, int]


def belt(rng: random.Random, products: int, *, gap_s: float = 0.2, noise_mg: int = 100):
    """Masses at 80 SPS while products of random weight pass: ramp, damped oscillation, ramp."""
    rows: list[Row] = []
    us = (1 << 32) - 400_000  # the clock wraps in the first product
    for _ in range(products):
        weight = rng.uniform(200_000, 1_000_000)
        stay_s, tone_hz = rng.uniform(0.24, 0.4), rng.uniform(5, 20)
        for n in range(round((stay_s + gap_s) * 1e6 / PERIOD_US)):
            t = n * PERIOD_US * 1e-6
            share = min(1.0, t / 0.03, max(0.0, (stay_s - t) / 0.03))
            swing = 0.05 * math.exp(-t / 0.1) * math.cos(2 * math.pi * tone_hz * t)
            us = (us + PERIOD_US) % (1 << 32)
            rows.append(
                (round(weight * share * (1 + swing)) + rng.randint(-noise_mg, noise_mg), us)
            )
    return rows


def _wander(rng: random.Random, products: int) -> list[Row]:
    """Products of any size, ringing or not, quiet or wild, long and short, with gaps at their end.

    Some come on the heels of the one before, so that a verdict and an entry fall together.
    """
    rows: list[Row] = []
    us = 0
    for _ in range(products):
        weight = rng.choice((2, 3, 1000, 70_000, 4_194_304, 1 << 29, 1 << 30))
        swing = rng.choice((0.0, 0.001, 0.2, 0.6)) * weight
        tone, fade = rng.uniform(0.02, 3.1), rng.choice((0.0, 0.05, 0.3))
        for n in range(rng.choice((1, 2, 11, 12, 14, 32, 40))):
            us = (us + rng.choice((PERIOD_US, PERIOD_US, 499_000, 500_000))) % (1 << 32)
            mass = weight + swing * math.exp(-fade * n) * math.cos(tone * n + 1.0)
            far = rng.random() < 0.002
            rows.append(((1 << 31) - 1 if far else round(mass), us))
        for _ in range(rng.choice((1, 1, 2, 3))):
            us = (us + rng.choice((PERIOD_US, PERIOD_US, PERIOD_US, 500_001))) % (1 << 32)
            rows.append((rng.choice((0, 0, -(1 << 31))), us))
    return rows


def _cases() -> Iterator[tuple[str, str, dict, list[Row]]]:
    rng = random.Random(SEED + 40)
    yield "belt", "products of random weight, one verdict each", USUAL, belt(rng, 24)
    short = USUAL | {"samples_min": 14}
    spoilt = [row for row in belt(rng, 12) if rng.random() < 0.985]
    yield "unweighed", "gaps and stays too short", short, spoilt
    lying = [(500_000 + (n * 37) % 91, n * PERIOD_US) for n in range(1, 120)]
    ends = [(0, (120 + n) * PERIOD_US) for n in range(3)]
    yield "lying", "a product that stays: its first 32 masses", USUAL, [*lying, *ends]
    yield (
        "corners",
        "bounds of the configuration, of masses and of tones",
        CORNERS,
        _wander(rng, 60),
    )


def drafts() -> Iterator[Draft]:
    """All of checkweigher's."""
    for name, shows, config, rows in _cases():
        twin = exact_checkweigher.Checkweigher(config)
        played = []
        for mass_mg, device_us in rows:
            event = twin.update(mass_mg, device_us)
            played.append((mass_mg, device_us, event, twin.mass_mg))
        yield Draft(
            f"checkweigher_{name}",
            f"checkweigher: {shows}",
            {
                "mass_mg": "mg, int32",
                "device_us": "us, uint32",
                "event": "0 empty, 1 loaded, 2 verdict, 3 unweighed",
                "weighed_mg": "mg, int32, of the last product weighed",
            },
            played,
            origin=ORIGIN,
            seed=str(SEED + 40),
            parameters={
                **{
                    field: " ".join(map(str, value)) if isinstance(value, list) else str(value)
                    for field, value in config.items()
                },
                "final_weighed": str(twin.weighed),
                "final_unweighed": str(twin.unweighed),
                "final_entered_us": str(twin.entered_us),
                "final_left_us": str(twin.left_us),
                "final_per_minute_q8": str(twin.per_minute_q8),
            },
        )
