# SPDX-License-Identifier: MIT
"""Float64 truth for checkweigher.c."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

SAMPLES_MAX = 32
TAPS = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
TONE_MAX = 16.0  # 1/g of a tone that is one
BASE_MAX = 2**15 - 1  # of the first mass, in half units
GAIN = 20.0  # of the weight by its smoothed masses, sum of magnitudes: notes/checkweigher.md


@dataclass(frozen=True)
class Product:
    """One that has left; class_at and mass_mg are None where it could not be weighed."""

    entered_s: float
    left_s: float
    mass_mg: float | None
    class_at: int | None
    samples: int


def weight_mg(masses) -> float:
    """The constant under one damped tone, of evenly spaced (n,) float64 masses.

    v = -g (x - weight) - b d of the smoothed x, its second difference v and its first d over two
    samples: least squares for g, b and the weight. Where 1/g is no tone's, the mean.
    """
    smooth = np.convolve(np.asarray(masses, dtype=np.float64), TAPS, "valid")
    middle = smooth[1:-1]
    second = smooth[2:] - 2 * middle + smooth[:-2]
    first = smooth[2:] - smooth[:-2]
    moment = np.cov(np.stack([middle, second, first]), bias=True)
    det = moment[0, 0] * moment[2, 2] - moment[0, 2] ** 2
    g = moment[1, 2] * moment[0, 2] - moment[0, 1] * moment[2, 2]
    b = moment[0, 1] * moment[0, 2] - moment[1, 2] * moment[0, 0]
    found = middle.mean()
    if g > 0 and det < TONE_MAX * g:
        found += (second.mean() * det + first.mean() * b) / g
    return float(found)


def budget_mg(masses, base_mg: float) -> float:
    """How far checkweigher.c may be from `weight_mg` (shared_c/notes/checkweigher.md)."""
    unit_mg = 2.0 * 2.0 ** max(0.0, np.floor(np.log2(base_mg / BASE_MAX)) + 1)
    spread_mg = np.ptp(np.convolve(np.asarray(masses, dtype=np.float64), TAPS, "valid"))
    step_mg = max(unit_mg, spread_mg / 2**11)
    return GAIN * (unit_mg + step_mg) / 2 + unit_mg / 4 + 1.0


def checkweigher(mass_mg, time_s, config: Mapping) -> list[Product]:
    """Products that pass in (n,) float64 masses at (n,) rising times.

    config : fields of checkweigher_config_t. The samples of a stretch are taken as evenly spaced.
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
        held = np.flatnonzero(times[at:end] - times[at] >= settle_s - 1e-9) + at
        last_s = times[end] - times[end - 1]
        young = sum(last_s * (k + 1) < tail_s - 1e-9 for k in range(len(held)))
        stretch = masses[held[: len(held) - young][:SAMPLES_MAX]]
        whole = np.diff(times[at : end + 1]).max() <= gap_s + 1e-9
        weight = class_at = None
        if whole and len(stretch) >= config["samples_min"]:
            weight = weight_mg(stretch)
            class_at = int(np.searchsorted(limits, weight, side="right"))
        products.append(Product(times[at], times[end], weight, class_at, len(stretch)))
        at = end + 1
    return products
