# SPDX-License-Identifier: MIT
"""Golden vectors of temperature, from its exact twin."""

from __future__ import annotations

import random
from collections.abc import Iterator

from terazi.models.exact import COUNTS_MAX, COUNTS_MIN
from terazi.models.exact_temperature import Temperature
from tools.gen.golden import SEED, Draft

ORIGIN = "terazi.models.exact_temperature, the contract of the header in unbounded integers"
COUNTS = "counts, 24 bits in int32"
NO_READING = -32768  # in the column measured_centi: none before this sample
FIELDS = (
    "origin_counts", "reference_centi", "zero_counts_per_k_q4", "span_ppm_per_k_q4", "on"
)  # fmt: skip

Row = tuple[int, int]  # reading before it, raw


def _day(rng: random.Random) -> list[Row]:
    """A room that warms by 12 K and cools again, a reading every 8th sample, load on and off."""
    rows = []
    for at in range(480):
        centi = 2100 + round(1200 * (1 - abs(at - 240) / 240) + rng.gauss(0, 8))
        load = 430_000 if at // 60 % 2 else 0
        raw = 84_000 + load + round(rng.gauss(0, 39))
        rows.append((centi if at % 8 == 0 else NO_READING, raw))
    return rows


def _corners(rng: random.Random) -> list[Row]:
    """Both ends of temperature and counts, readings that are none, jumps."""
    rows = [(NO_READING, 12_345), (8501, 0), (-4001, 0), (8500, COUNTS_MAX)]
    for _ in range(120):
        centi = rng.choice((-4000, 8500, 8500, 32767, -32767, rng.randint(-4000, 8500)))
        rows.append(
            (centi, rng.choice((COUNTS_MIN, COUNTS_MAX, 0, -1, rng.randint(-1 << 23, 1 << 22))))
        )
    return rows


def drafts() -> Iterator[Draft]:
    """A usual cell, one that falls with warmth, all at the bounds, switched off."""
    rng = random.Random(SEED + 50)
    usual, corners = _day(rng), _corners(rng)
    configs = {
        "usual": ("a usual cell over a warm day", (84_000, 2300, 107 * 16, 20 * 16, 1), usual),
        "falls": ("zero and span that fall with warmth", (84_000, 3000, -1717, -803, 1), usual),
        "bounds": ("slopes at their bounds", (COUNTS_MIN, -4000, -32768, 4000, 1), corners),
        "bounds_falling": ("the same, falling", (COUNTS_MAX, 8500, 32767, -4000, 1), corners),
        "off": ("switched off, every count is passed on", (5, 2000, 777, 999, 0), corners),
    }
    for name, (shows, values, rows) in configs.items():
        twin = Temperature(dict(zip(FIELDS, values, strict=True)))
        table = []
        for measured, raw in rows:
            if measured != NO_READING:
                twin.update(measured)
            smoothed = NO_READING if twin.centi is None else twin.centi
            table.append((measured, raw, smoothed, twin.correct(raw)))
        yield Draft(
            f"temperature_{name}",
            f"temperature: {shows}",
            {
                "measured_centi": f"1/100 degC, int16; {NO_READING}: no reading before this sample",
                "raw_counts": COUNTS,
                "smoothed_centi": f"1/100 degC, int16; {NO_READING}: none yet",
                "corrected_counts": COUNTS,
            },
            table,
            origin=ORIGIN,
            seed=str(SEED + 50),
            parameters={
                **{field: str(value) for field, value in zip(FIELDS, values, strict=True)},
                "refused": str(twin.refused),
                "clipped": str(twin.clipped),
            },
        )
