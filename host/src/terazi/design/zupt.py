# SPDX-License-Identifier: MIT
"""zupt.h's configuration from physical quantities, which are in shared_c/spec/zupt.toml."""

from __future__ import annotations

import tomllib
from functools import cache
from math import radians

from terazi.design.specs import CHECKOUT, INSTALLED

STANDARD_GRAVITY_M_S2 = 9.80665
BLOCK, VISITS = 4, 9  # ZUPT_BLOCK, ZUPT_VISITS
GRAVITY_COUNTS = 2048
WEIGHT_MAX = 6
VISIT_RATE_HZ = 500.0
ACC_WEIGHT = {"shoe": 1, "are": 0, "moving_variance": 1, "magnitude": BLOCK * BLOCK}
MAGNITUDE_FACTOR = 4  # its squares are those of half counts


@cache
def spec() -> dict:
    """zupt.toml, whole."""
    folder = INSTALLED if INSTALLED.is_dir() else CHECKOUT
    return tomllib.loads((folder / "zupt.toml").read_text(encoding="utf-8"))


def detectors() -> tuple[str, ...]:
    """Names; the first is number 1 of zupt.h."""
    return tuple(entry["name"] for entry in spec()["detector"])


def turns(name: str) -> bool:
    """Whether a detector's limits are rates, of the gyroscope."""
    return name in ("shoe", "are")


def counts_per_unit(name: str, sensor: dict) -> float:
    """Counts of what the detector's limits are in, rad/s or m/s^2."""
    if turns(name):
        return sensor["gyro_counts_per_deg_s"] / radians(1.0)
    return sensor["acc_counts_per_g"] / STANDARD_GRAVITY_M_S2


def gyro_weight(entry: dict, sensor: dict) -> int:
    """Weight of the rate's squares, those of the acceleration being 1 where both count."""
    if entry["name"] != "shoe":
        return 1 if turns(entry["name"]) else 0
    acc_counts = entry["m_s2_per_rad_s"] * sensor["acc_counts_per_g"] / STANDARD_GRAVITY_M_S2
    return round((acc_counts / counts_per_unit("shoe", sensor)) ** 2)


def squares_per_count2(entry: dict, sensor: dict) -> int:
    """What a block's sum is for a root mean square of one count."""
    if entry["name"] == "magnitude":
        return BLOCK * MAGNITUDE_FACTOR
    return BLOCK * max(gyro_weight(entry, sensor), 1)


def config(entry: dict, sensor: dict, stride: int = 1) -> dict:
    """Fields of zupt_config_t of a [[detector]]; stride is that of a [[rate]].

    Raises ValueError where a field would not hold its contract.
    """
    name = entry["name"]
    unit = "rad_s" if turns(name) else "m_s2"
    if sensor["acc_counts_per_g"] != GRAVITY_COUNTS:
        raise ValueError(f"zupt.h takes {GRAVITY_COUNTS} counts for 1 g")
    factor = squares_per_count2(entry, sensor)
    limits = [
        round(factor * (entry[f"{side}_{unit}"] * counts_per_unit(name, sensor)) ** 2)
        for side in ("enter", "leave")
    ]
    fields = {
        "begin_squares": [-limit for limit in limits],
        "detector": detectors().index(name) + 1,
        "acc_weight": ACC_WEIGHT[name],
        "gyro_weight": gyro_weight(entry, sensor),
        "still_blocks": entry["still_blocks"],
        "stride": stride,
    }
    lawful = {
        "begin_squares": 0 < limits[0] <= limits[1] <= 1 << 31,
        "gyro_weight": (1 if turns(name) else 0) <= fields["gyro_weight"] <= WEIGHT_MAX,
        "still_blocks": 1 <= fields["still_blocks"] <= 255,
        "stride": 1 <= fields["stride"] <= 255,
    }
    broken = [f"{field} {fields[field]}" for field, holds in lawful.items() if not holds]
    if broken:
        raise ValueError(f"{name} breaks zupt.h's contract by {', '.join(broken)}")
    return fields


def entry_of(name: str, **changed: float) -> dict:
    """A [[detector]] of zupt.toml; `changed` are keys of it with another value."""
    found = [entry for entry in spec()["detector"] if entry["name"] == name]
    if not found:
        raise ValueError(f"no detector {name!r}; there are {', '.join(detectors())}")
    unknown = [key for key in changed if key not in found[0] or key == "name"]
    if unknown:
        raise ValueError(f"{name} has no {', '.join(unknown)} in zupt.toml")
    return {**found[0], **changed}


def config_at(name: str, rate_hz: float = VISIT_RATE_HZ, **changed: float) -> dict:
    """Fields of zupt_config_t of a detector at any rate, with blocks about as long."""
    stride = max(1, round(rate_hz / VISIT_RATE_HZ))
    return config(entry_of(name, **changed), spec()["sensor"], stride)
