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
    "settle_us": 60_000,
    "tail_us": 60_000,
    "gap_us": 50_000,
    "classes": 4,
    "samples_min": 5,
}
CORNERS = {
    "limit_mg": [-(1 << 30), -1, 0, 1, 1_000_000, 2_000_000, 1 << 30],
    "enter_mg": 2,
    "leave_mg": 1,
    "settle_us": 0,
    "tail_us": 0,
    "gap_us": 500_000,
    "classes": 8,
    "samples_min": 1,
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


def _wander(rng: random.Random, count: int) -> list[Row]:
    rows, us = [], 0
    for _ in range(count):
        us = (us + rng.choice((1, PERIOD_US, 499_000, 500_001))) % (1 << 32)
        far = rng.choice(
            (0, 1, 2, 1000, 1_500_000, 4_194_304, 4_194_306, (1 << 31) - 1, -(1 << 31))
        )
        rows.append((far, us))
    return rows


def _cases() -> Iterator[tuple[str, str, dict, list[Row]]]:
    rng = random.Random(SEED + 40)
    yield "belt", "products of random weight, one verdict each", USUAL, belt(rng, 24)
    short = USUAL | {"samples_min": 14}
    spoilt = [row for row in belt(rng, 12) if rng.random() < 0.9]
    yield "unweighed", "gaps and stays too short", short | {"gap_us": 26_000}, spoilt
    lying = [(500_000 + (n * 37) % 91, n * PERIOD_US) for n in range(1, 120)]
    yield "lying", "a product that stays: the last 32 masses", USUAL, [*lying, (0, 120 * PERIOD_US)]
    yield "corners", "bounds of the configuration and of masses", CORNERS, _wander(rng, 300)


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
                "final_counts": " ".join(map(str, twin.counts)),
                "final_unweighed": str(twin.unweighed),
                "final_entered_us": str(twin.entered_us),
                "final_left_us": str(twin.left_us),
                "final_per_minute_q8": str(twin.per_minute_q8),
            },
        )
