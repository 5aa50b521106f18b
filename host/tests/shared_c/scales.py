# SPDX-License-Identifier: MIT
"""What the tests of scale share: lawful configurations, and weights that lie on it."""

from itertools import pairwise

import numpy as np
from hypothesis import strategies as st

from terazi.cshared import Scale
from terazi.design import scale as design
from terazi.models import exact_scale

PERIOD_US = 12_500  # 80 SPS
RECIPROCALS = design.reciprocals(design.spec())
COUNTS_PER_G = design.default_points()[1][0] / design.default_points()[1][1]
Q7 = design.ONE_COUNT_Q7
E_MG = 1000  # of the usual configuration
int32 = st.integers(-(1 << 31), (1 << 31) - 1)
uint32 = st.integers(0, (1 << 32) - 1)


def counts_q7_of(grams) -> np.ndarray:
    """Estimates of the nominal cell."""
    return np.rint(np.asarray(grams, dtype=float) * COUNTS_PER_G * Q7).astype(np.int64)


def times_us(count: int, period_us: int = PERIOD_US, start_us: int = 0) -> np.ndarray:
    return (start_us + period_us * np.arange(1, count + 1)) % (1 << 32)


def weigh(scale: Scale, grams, start_us: int | None = None):
    """Flags, net masses and what is shown; the clock goes on."""
    start_us = scale.last_us if start_us is None else start_us
    return scale.block(counts_q7_of(grams), times_us(len(grams), start_us=start_us))


def lying(grams: float, count: int = 60) -> np.ndarray:
    return np.full(count, float(grams))


@st.composite
def lawful_configs(draw):
    """Any configuration that scale.h allows, with e, d and times that something happens under."""
    count = draw(st.integers(2, 8))
    sign = draw(st.sampled_from((1, -1)))
    limit = exact_scale.COUNTS_MAX
    counts = sorted(draw(st.sets(st.integers(-limit, limit), min_size=count, max_size=count)))
    masses = [draw(st.integers(-500_000, 500_000))]
    for low, high in pairwise(counts):
        most = min(high - low - 1, exact_scale.POINT_MASS_MAX - masses[-1])
        if most < 1:
            break
        masses.append(masses[-1] + draw(st.integers(1, most)))
    if len(masses) < 2:
        counts, masses = [0, 1000], [0, 999]
    points = len(masses)
    max_mg = draw(st.integers(16, exact_scale.MAX_MAX))
    e_mg = draw(st.integers(1, max_mg // 16))
    unit, decimals, digit = draw(
        st.sampled_from(
            [
                (unit, decimals, digit)
                for unit in range(len(RECIPROCALS))
                for decimals in range(7)
                for digit in design.DIGITS
            ]
        )
    )
    config = {
        "point_counts_q7": [sign * each for each in counts[:points]] + [0] * (8 - points),
        "point_mass_mg": masses + [0] * (8 - points),
        "max_mg": max_mg,
        "interval_mg": e_mg,
        "under_mg": draw(st.integers(0, max_mg)),
        "step_mg": draw(st.integers(0, max_mg)),
        "stable_band_mg": draw(st.integers(0, e_mg // 2)),
        "stable_us": draw(st.sampled_from((1, 20_000, 500_000, 1 << 31))),
        "gap_us": draw(st.sampled_from((1, 20_000, 250_000, 1 << 31))),
        "points": points,
        "unit": unit,
        "decimals": decimals,
        "digit": digit,
        "hysteresis_q8": draw(st.integers(0, 127)),
        "options": draw(st.integers(0, 3)),
    }
    if exact_scale.per_division(config, RECIPROCALS) is None:
        config |= {"unit": 1, "decimals": 0}
    return config
