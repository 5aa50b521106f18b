# SPDX-License-Identifier: MIT
"""Golden vectors of zupt_gru, from its exact twin."""

from __future__ import annotations

import random
from collections.abc import Iterator

from terazi.models import exact_zupt_gru
from tools.gen.golden import SEED, Draft
from tools.gen.golden_zupt import AXES, INT16, Sample, lying, walk
from tools.gen.zupt_gru_weights import weights

LOW, HIGH = exact_zupt_gru.RAILS
BEYOND = (LOW, -8193, -8192, 8191, 8192, HIGH)
RATES = {"1000hz": 1, "500hz": 2}


def loudness(rng: random.Random, count: int) -> list[Sample]:
    """Vectors of every size there is, from nothing to full scale, as likely in any octave."""
    samples = []
    for _ in range(count):
        size, shake = (2 ** rng.uniform(0, 14.5) for _ in range(2))
        gyro = tuple(round(max(min(rng.gauss(0, size), HIGH - 1), LOW + 1)) for _ in AXES)
        acc = tuple(
            round(max(min(rng.gauss(at, shake), HIGH - 1), LOW + 1)) for at in (0, -1448, 1448)
        )
        samples.append((gyro, acc))
    return samples


def edges(rng: random.Random, count: int) -> list[Sample]:
    """A foot at rest that is hit: a value at what it may be, beyond that, or on a rail."""
    samples = []
    for gyro, acc in lying(rng, count):
        vectors = [list(gyro), list(acc)]
        if rng.random() < 0.15:
            vectors[rng.randrange(2)][rng.randrange(3)] = rng.choice(BEYOND)
        samples.append((tuple(vectors[0]), tuple(vectors[1])))
    nothing = [((0, 0, 0), (0, 0, 0)), ((0, 0, 0), (0, 2048, 0)), ((0, 0, 0), (0, 0, 2049))]
    corners = [((value,) * 3, (value,) * 3) for value in BEYOND]
    return [*samples, *(each for each in nothing + corners for _ in range(5))]


def _cases() -> Iterator[tuple[str, str, int, list[Sample], int]]:
    """Name, what it shows, ms a sample, samples, and where a gap is."""
    rng = random.Random(SEED + 70)
    for rate, sample_ms in RATES.items():
        samples = walk(rng, 2, 1000.0 / sample_ms)[200 // sample_ms : 900 // sample_ms]
        yield f"walk_{rate}", "a foot that stands and swings", sample_ms, samples, 0
    for rate, sample_ms in RATES.items():
        yield f"sizes_{rate}", "vectors of any size", sample_ms, loudness(rng, 400), 0
    yield "edges_500hz", "values at what they may be, and rails", 2, edges(rng, 400), 0
    for gap in (161, 162):  # between a step's two calls, and after them
        samples = [*lying(rng, gap), *loudness(rng, 20), *lying(rng, 120)]
        yield f"gap_{gap}_1000hz", f"a gap before sample {gap}", 1, samples, gap


def drafts() -> list[Draft]:
    """Feet, sizes, edges and gaps; every state after every sample."""
    found = []
    for name, shows, sample_ms, samples, gap in _cases():
        twin, rows = exact_zupt_gru.ZuptGru(weights(), sample_ms), []
        for at, (gyro, acc) in enumerate(samples):
            if gap and at == gap:
                twin.interrupt()
            flag = twin.update(gyro, acc)
            rows.append((*gyro, *acc, flag, *twin.seen))
        found.append(
            Draft(
                f"zupt_gru_{name}",
                f"zupt_gru, a sample every {sample_ms} ms: {shows}",
                {f"gyro_{axis}_counts": INT16 for axis in AXES}
                | {f"acc_{axis}_counts": INT16 for axis in AXES}
                | {"still": "1 or 0"}
                | {f"input_{n}": "octaves, Q10 in int16" for n in range(2)}
                | {f"state_{n}": "Q13 in int16" for n in range(8)},
                rows,
                origin="terazi.models.exact_zupt_gru, contracts of the headers, unbounded integers",
                seed=str(SEED + 70),
                parameters={
                    "sample_ms": str(sample_ms),
                    "gap": f"{gap} (sample before which there is one, or 0)",
                    "rejected": str(twin.rejected),
                },
            )
        )
    return found
