# SPDX-License-Identifier: MIT
"""Float64 truth for checkweigher.c."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

MASS_BUDGET_MG = 1.0  # shared_c/notes/checkweigher.md
SAMPLES_MAX = 32
SPREAD_MG = 2.0**22
AGE_STEP_S = 256e-6


@dataclass(frozen=True)
class Product:
    """One that has left; class_at and mass_mg are None where it could not be weighed."""

    entered_s: float
    left_s: float
    mass_mg: float | None
    class_at: int | None
    samples: int


def checkweigher(mass_mg, time_s, config: Mapping) -> list[Product]:
    """Products that pass in (n,) float64 masses at (n,) rising times.

    config : fields of checkweigher_config_t.
    The C rounds ages to 256 us and the mean to 1 mg: where no sample is nearer than AGE_STEP_S to
    the tail's begin, masses agree within MASS_BUDGET_MG.
    """
    limits = np.array(config["limit_mg"][: config["classes"] - 1])
    settle_s, tail_s, gap_s = (config[f"{name}_us"] * 1e-6 for name in ("settle", "tail", "gap"))
    products, masses = [], np.asarray(mass_mg, dtype=np.float64)
    times = np.asarray(time_s, dtype=np.float64)
    at = 0
    while at < len(masses):
        if masses[at] < config["enter_mg"]:
            at += 1
            continue
        below = np.flatnonzero(masses[at:] < config["leave_mg"])
        if len(below) == 0:
            break
        end = at + below[0]
        on = slice(at, end)
        settled = np.flatnonzero(times[on] - times[at] >= settle_s - 1e-9)[-SAMPLES_MAX:] + at
        stretch = settled[times[end] - times[settled] >= tail_s - 1e-9]
        whole = np.diff(times[at : end + 1]).max() <= gap_s + 1e-9
        weight = None
        if whole and len(stretch) >= config["samples_min"]:
            rising = np.arange(1, len(stretch) + 1)
            if np.ptp(np.append(masses[stretch] - masses[stretch[0]], 0)) <= SPREAD_MG:
                weights = np.minimum(rising, rising[::-1])
                weight = float(weights @ masses[stretch] / weights.sum())
        class_at = None if weight is None else int(np.searchsorted(limits, weight, side="right"))
        products.append(Product(times[at], times[end], weight, class_at, len(stretch)))
        at = end + 1
    return products
