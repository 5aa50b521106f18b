# SPDX-License-Identifier: MIT
"""Golden vectors of zupt, from its exact twin."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator

from terazi.design import zupt as design
from terazi.models import exact_zupt
from tools.gen.golden import SEED, Draft

LOW, HIGH = exact_zupt.RAILS
INT16 = "counts, int16"
AXES = "xyz"
Sample = tuple[tuple[int, ...], tuple[int, ...]]
LEAST = {"begin_squares": [-1, -(1 << 31)], "still_blocks": 1, "stride": 1}
CORNERS = {  # limits of one count^2 and of 2^31, the largest weight
    "corners_shoe": {**LEAST, "detector": 1, "acc_weight": 1, "gyro_weight": 6},
    "corners_moving_variance": {**LEAST, "detector": 3, "acc_weight": 1, "gyro_weight": 0},
    "open_are": {
        "begin_squares": [-(1 << 31)] * 2,
        "detector": 2,
        "acc_weight": 0,
        "gyro_weight": 6,
        "still_blocks": 1,
        "stride": 3,
    },
    "open_magnitude": {
        "begin_squares": [-(1 << 31)] * 2,
        "detector": 4,
        "acc_weight": 16,
        "gyro_weight": 0,
        "still_blocks": 3,
        "stride": 1,
    },
}


def _noisy(rng: random.Random, values, spread: float) -> tuple[int, ...]:
    return tuple(round(rng.gauss(value, spread)) for value in values)


def walk(rng: random.Random, steps: int, rate_hz: float) -> list[Sample]:
    """A foot that stands, rolls off, swings and lands: shapes alone, sizes as they are recorded."""
    samples = []
    stance, swing = round(0.35 * rate_hz), round(0.3 * rate_hz)
    tilt = 0.3
    for step in range(steps):
        settle = 12 + 60 * step  # each stance less quiet than the one before
        for n in range(stance):
            ring = settle * math.exp(-n / (0.03 * rate_hz)) + settle / 12
            acc = (2048 * math.sin(tilt), 20.0, 2048 * math.cos(tilt))
            samples.append((_noisy(rng, (3, -5, 8), ring), _noisy(rng, acc, 4 + ring)))
        for n in range(swing):
            phase = math.sin(math.pi * n / swing)
            rate = (300 * phase, 6500 * phase * math.sin(2 * math.pi * n / swing), -200 * phase)
            acc = (700 * phase, 300 * phase, 2048 + 3500 * phase * math.cos(6 * n / swing))
            samples.append((_noisy(rng, rate, 40), _noisy(rng, acc, 60)))
    return samples


def edges(rng: random.Random, sets: int) -> list[Sample]:
    """Blocks of values at, and now and then beyond, what a value may be; some on a rail."""
    at = (-4096, 4095, 0, 2048)
    samples = [(tuple([-4096] * 3), tuple([-4096] * 3))] * 27
    for _ in range(sets):
        block = [
            [tuple(rng.choice(at) for _ in AXES) for _ in range(2)] for _ in range(design.VISITS)
        ]
        if rng.random() < 0.5:
            hit, sensor, axis = rng.randrange(design.VISITS), rng.randrange(2), rng.randrange(3)
            vector = list(block[hit][sensor])
            vector[axis] = rng.choice((-4097, 4096, LOW, HIGH, LOW + 1, HIGH - 1))
            block[hit][sensor] = tuple(vector)
        samples += [(gyro, acc) for gyro, acc in block]
    return samples


def lying(rng: random.Random, count: int) -> list[Sample]:
    """At rest, without noise for a while and with some then."""
    flat = [((0, 0, 0), (0, 0, 2048))] * (count // 2)
    return flat + [(_noisy(rng, (2, -1, 0), 1.5), _noisy(rng, (300, -200, 2016), 5))
                   for _ in range(count // 2)]  # fmt: skip


def _cases() -> Iterator[tuple[str, str, dict, list[Sample]]]:
    rng = random.Random(SEED + 60)
    for name in design.detectors():
        yield name, f"{name} on a foot at 500 Hz", design.config_at(name), walk(rng, 3, 500.0)
    yield (
        "shoe_1000hz",
        "shoe on a foot at 1 kHz",
        design.config_at("shoe", 1000.0),
        walk(rng, 2, 1000.0),
    )
    for name in design.detectors():
        mixed = lying(rng, 90) + edges(rng, 24) + lying(rng, 60)
        shows = f"{name}: values at what they may be, and rails"
        yield f"{name}_edges", shows, design.config_at(name), mixed
    for name, config in CORNERS.items():
        mixed = lying(rng, 90) + edges(rng, 30)
        part, detector = name.split("_", 1)
        shows = f"{detector}, {part}: a configuration at its bounds, values at theirs"
        yield name, shows, config, mixed


def drafts() -> list[Draft]:
    """Feet, edges and corners."""
    found = []
    for name, shows, config, samples in _cases():
        twin = exact_zupt.Zupt(config)
        rows = [(*gyro, *acc, twin.update(gyro, acc)) for gyro, acc in samples]
        enter, leave = config["begin_squares"]
        fields = {key: value for key, value in config.items() if key != "begin_squares"}
        found.append(
            Draft(
                f"zupt_{name}",
                f"zupt: {shows}",
                {f"gyro_{axis}_counts": INT16 for axis in AXES}
                | {f"acc_{axis}_counts": INT16 for axis in AXES}
                | {"still": "1 or 0"},
                rows,
                origin="terazi.models.exact_zupt, the contract of the header, unbounded integers",
                seed=str(SEED + 60),
                parameters={
                    "begin_enter_squares": str(enter),
                    "begin_leave_squares": str(leave),
                    **{field: str(value) for field, value in fields.items()},
                    "rejected": str(twin.rejected),
                },
            )
        )
    return found
