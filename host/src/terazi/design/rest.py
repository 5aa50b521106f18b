# SPDX-License-Identifier: MIT
"""rest.h's configuration from physical quantities, which are in shared_c/spec/rest.toml."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from functools import cache

from terazi.design.specs import CHECKOUT, INSTALLED

STANDARD_GRAVITY_M_S2 = 9.80665
VISITS = 6  # samples a round: three axes of two sensors, rest.h
BLOCK_ROUNDS = 16  # REST_BLOCK_ROUNDS: rounds that gather
LEARN_ROUNDS = 1  # and one that learns
FIRST_SHIFT = 3  # REST_FIRST_SHIFT: still_rounds / 8 do until the bias is known
GRAVITY_STEP_COUNTS = 256
COUNT_MAX = 255  # of rounds, of blocks


def timing(rate_hz: float, times: dict) -> dict[str, float]:
    """Gain and lengths in visits and rounds of rest.toml's [times]; counts are whole already.

    The bias's gain is a power of two, so that its time constant is the nearest that there is.
    """
    round_s = VISITS / rate_hz
    blocks = times["bias_s"] / block_s(rate_hz)
    still_rounds = max(1, round(times["still_s"] / round_s))
    return {
        "lowpass_gain": round_s / times["lowpass_s"],
        "still_rounds": still_rounds,
        "first_rounds": max(1, still_rounds >> FIRST_SHIFT),
        "gain_len": 1 << max(0, round(math.log2(blocks))),
    }


def block_s(rate_hz: float) -> float:
    """How long it takes to learn once."""
    return VISITS * (BLOCK_ROUNDS + LEARN_ROUNDS) / rate_hz


def config(rate_hz: float, *, limits: dict, times: dict, sensor: dict) -> dict[str, int]:
    """Fields of rest_config_t by name; limits, times and sensor are those tables of rest.toml.

    Raises ValueError where a field would not hold its contract.
    """
    gyro = sensor["gyro_counts_per_deg_s"]
    acc = sensor["acc_counts_per_g"] / STANDARD_GRAVITY_M_S2
    steps = sensor["acc_counts_per_g"] / GRAVITY_STEP_COUNTS
    timed = timing(rate_hz, times)
    fields = {
        "enter_acc_counts": round(limits["enter_acc_m_s2"] * acc),
        "leave_acc_counts": round(limits["leave_acc_m_s2"] * acc),
        "enter_gyro_counts": round(limits["enter_gyro_deg_s"] * gyro),
        "leave_gyro_counts": round(limits["leave_gyro_deg_s"] * gyro),
        "bias_max_counts": round(limits["bias_max_deg_s"] * gyro),
        "lowpass_q16": round(timed["lowpass_gain"] * 65536),
        "still_rounds": timed["still_rounds"],
        "gain_len": timed["gain_len"],
        "gravity2_min": round((limits["gravity_min_g"] * steps) ** 2),
        "gravity2_max": round((limits["gravity_max_g"] * steps) ** 2),
    }
    lawful = {
        "enter_acc_counts": 0 <= fields["enter_acc_counts"] <= fields["leave_acc_counts"],
        "leave_acc_counts": fields["leave_acc_counts"] <= 16383,
        "enter_gyro_counts": 0 <= fields["enter_gyro_counts"] <= fields["leave_gyro_counts"],
        "bias_max_counts": fields["bias_max_counts"] >= 0
        and fields["leave_gyro_counts"] + fields["bias_max_counts"] <= 2046,
        "lowpass_q16": 1 <= fields["lowpass_q16"] <= 32767,
        "still_rounds": fields["still_rounds"] <= COUNT_MAX,
        "gain_len": fields["gain_len"] <= COUNT_MAX,
        "gravity2_min": 0 <= fields["gravity2_min"] <= fields["gravity2_max"] < 1 << 16,
    }
    broken = [f"{name} {fields[name]}" for name, holds in lawful.items() if not holds]
    if broken or not math.isfinite(rate_hz):
        raise ValueError(f"at {rate_hz} Hz rest.h's contract is broken by {', '.join(broken)}")
    return fields


def as_c(fields: Mapping[str, int]) -> dict:
    """The fields as rest_config_t holds them: the limits as a table."""
    rest = dict(fields)
    limits = [
        [rest.pop(f"{when}_{sensor}_counts") for when in ("enter", "leave")]
        for sensor in ("acc", "gyro")
    ]
    return {"limit_counts": limits, **rest}


def gain(block: int) -> float:
    """Share of the bias that the block-th learnt one (from 1) takes, nearly the mean of all."""
    return 2.0 ** -math.floor(math.log2(block))


@cache
def spec() -> dict:
    """rest.toml, whole."""
    folder = INSTALLED if INSTALLED.is_dir() else CHECKOUT
    return tomllib.loads((folder / "rest.toml").read_text(encoding="utf-8"))


def config_at(rate_hz: float, **changed: float) -> dict[str, int]:
    """Fields of rest_config_t at any rate; `changed` are keys of rest.toml with another value."""
    tables = {name: dict(spec()[name]) for name in ("limits", "times", "sensor")}
    for key, value in changed.items():
        homes = [table for table in tables.values() if key in table]
        if not homes:
            raise ValueError(f"rest.toml has no {key}")
        homes[0][key] = value
    return config(rate_hz, **tables)
