# SPDX-License-Identifier: MIT
"""Golden vectors of weight_kf_adaptive, from its exact twin."""

from __future__ import annotations

import random
from collections.abc import Iterator

from terazi.design import specs
from terazi.models.exact import INT32_MAX, INT32_MIN
from terazi.models.exact_weight_kf_adaptive import Variant, adaptive
from tools.gen.golden import ANY_COUNTS, COUNTS_Q7, RAIL_HIGH, RAIL_LOW, SEED, Draft

ORIGIN = "terazi.models.exact_weight_kf_adaptive, the contract of the header in unbounded integers"


def _noisy(rng: random.Random, sigma: float, levels: list[int]) -> list[int]:
    return [round(level + rng.gauss(0, sigma)) for level in levels]


def signals(rng: random.Random) -> dict[str, tuple[str, list[int]]]:
    """name -> what it shows, samples; the first of them starts the filter."""
    loads = [0] * 150 + [429_550] * 150 + [429_850] * 100 + [429_550] * 100
    tap = [1000] * 60 + [40_000] * 6 + [1000] * 60
    ramp = [8000 * n for n in range(40)] + [320_000] * 60 + [320_000 - 90 * n for n in range(80)]
    spikes = _noisy(rng, 5.0, [77_000] * 120)
    for at in range(10, 120, 11):
        spikes[at] = rng.choice((RAIL_LOW, RAIL_HIGH, 77_000 + rng.randint(-400, 400)))
    rails = [RAIL_LOW] * 8 + [RAIL_HIGH] * 8 + [RAIL_LOW, RAIL_HIGH] * 6 + [RAIL_HIGH] * 40
    rails += [INT32_MIN, INT32_MAX, RAIL_LOW - 1, RAIL_HIGH + 1] * 3
    return {
        "weight": ("loads that come and go in converter noise", _noisy(rng, 38.7, loads)),
        "tap": ("a load that goes back to where it was", _noisy(rng, 9.0, tap)),
        "ramp": ("a fast and a slow ramp", _noisy(rng, 20.0, ramp)),
        "spikes": ("spikes of any size, one at a time", spikes),
        "quiet": ("no noise at all", [5] * 40 + [6] * 40 + [900] * 40),
        "loud": ("noise beyond what is learnt", _noisy(rng, 900.0, [-3_000_000] * 150)),
        "rails": ("rails, and samples beyond them, which are clamped and counted", rails),
        "random": (
            "uniform noise of full scale",
            [rng.randint(RAIL_LOW, RAIL_HIGH) for _ in range(80)],
        ),
    }


def drafts() -> Iterator[Draft]:
    """The filter alone and the two models, each variant."""
    for index, variant in enumerate(specs.weight_kf_adaptive_variants()):
        config = Variant(**specs.weight_kf_adaptive_config(index))
        for pair in (False, True):
            kind = "pair" if pair else "single"
            for name, (shows, measured) in signals(random.Random(SEED + 30)).items():
                estimates, clipped = adaptive(measured, config, measured[0], pair=pair)
                yield Draft(
                    f"weight_kf_adaptive_{variant['name']}_{kind}_{name}",
                    f"weight_kf_adaptive, {kind}, variant {variant['name']}: {shows}",
                    {"measured_counts": ANY_COUNTS, "estimate_counts_q7": COUNTS_Q7},
                    list(zip(measured, estimates, strict=True)),
                    origin=ORIGIN,
                    seed=str(SEED + 30),
                    parameters={
                        "variant": f"{index} ({variant['name']})",
                        "pair": str(int(pair)),
                        "first_counts": str(measured[0]),
                        "clipped": str(clipped),
                    },
                )
