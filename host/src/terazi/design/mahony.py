# SPDX-License-Identifier: MIT
"""mahony.h's configuration from physical quantities, which are in shared_c/spec/mahony.toml."""

from __future__ import annotations

import math
import tomllib
from functools import cache

from terazi.design.specs import CHECKOUT, INSTALLED

MODES = ("second_order", "linear", "classic")
RAMP_LEN = 12  # MAHONY_RAMP_LEN: blocks; a third of them each eightfold, fourfold, twofold
RAMP_MASK_MAX = 255  # of 8 bits
GAP_MAX = 255
MODE_FIELDS = ("steps", "mode", "integral")  # of mahony_modes_config_t, beside `usual`
GYRO_Q33_MAX = 16128
CORRECT_Q18_MAX = 4095
ONE_G_Q25 = 2048  # counts a g for which correct_q18 is kp dt in Q18
MAG_BLOCK = 8  # MAHONY_MAG_BLOCK
MAG_TURNS = 4  # in each of them
HEADING_Q21_MAX = 14_000


def turn_constants(rate_hz: float, gyro_counts_per_deg_s: float) -> dict[str, int]:
    """How a gyroscope's counts become half angles of one step.

    square is rounded; its relative error, kappa, is taken out of the direction by cubic: with
    cos = 1 - (1 + kappa) h^2 / 2 the sine's factor must be 1 - s h^2, s = (1 + kappa) / 2 - 1/3.
    """
    half_angle_q33 = math.radians(1 / gyro_counts_per_deg_s) / rate_hz / 2 * 2**33
    steps = max(1, math.ceil(half_angle_q33 / GYRO_Q33_MAX))
    gyro = round(half_angle_q33 / steps)
    square = max(1, round(gyro**2 / 2**18))
    cosine = square / (gyro**2 / 2**18) / 2
    return {
        "gyro_q33": gyro,
        "square": square,
        "cubic": round(gyro * (cosine - 1 / 3) / cosine / 2),
        "steps": steps,
    }


def start_shift(rate_hz: float, gyro_rad_s: float, acc_counts_per_g: float) -> int:
    """2 to this makes a rate of an acceleration in Q14 so that half of a small tilt is turned in
    one sample, 0.35 to 0.7 of it."""
    rate_by_sine = rate_hz / gyro_rad_s  # counts that turn by the sine in one sample
    return min(30, max(1, math.ceil(14.5 - math.log2(rate_by_sine / acc_counts_per_g))))


def _heading_q21(blocks: float) -> int:
    """Gain of each of the MAG_TURNS turns of a block."""
    return max(1, min(HEADING_Q21_MAX, round(2**20 / (blocks * MAG_TURNS))))


def _gains(mode: str, tables: dict) -> tuple[float, float, float]:
    """kp, lp and ki in rad/s, 1/s and rad/s^2."""
    if mode == "second_order":
        tau_s = tables["second_order"]["tau_s"]
        return 1 / tau_s, 2 / tau_s, tables["second_order"]["ki_rad_s2"]
    return tables[mode]["kp_rad_s"], 0.0, tables[mode]["ki_rad_s2"]


def config(rate_hz: float, mode: str = "second_order", *, mag_rate_hz=None, **tables) -> dict:
    """Fields of mahony_config_t; tables are those of mahony.toml.

    mag_rate_hz : of mahony_update_mag; None: rate_hz.
    Raises ValueError where a field would not hold its contract.
    """
    sensor, start, field = (tables[name] for name in ("sensor", "start", "field"))
    kp, lp, ki = _gains(mode, tables)
    mag_rate_hz = mag_rate_hz or rate_hz
    normalised = mode == "classic"
    scale = 1.0 if normalised else ONE_G_Q25 / sensor["acc_counts_per_g"]
    gyro_rad_s = math.radians(1 / sensor["gyro_counts_per_deg_s"])
    ramp_block = 2 ** max(0, round(math.log2(start["ramp_s"] * rate_hz / RAMP_LEN)))
    block_hz = mag_rate_hz / MAG_BLOCK
    turn = turn_constants(rate_hz, sensor["gyro_counts_per_deg_s"])
    steps = turn.pop("steps")
    fields = {
        **turn,
        "lowpass_q16": round(lp / rate_hz * 65536),
        "correct_q18": max(1, round(kp / rate_hz * 2**18 * scale)),
        "acc_one_g": round(sensor["acc_counts_per_g"]),
        "ramp_mask": ramp_block - 1,
        "gap_max": round(start["gap_s"] * rate_hz),
        "start_shift": start_shift(rate_hz, gyro_rad_s, sensor["acc_counts_per_g"]),
        "mag_correct_q21": _heading_q21(block_hz * field["heading_tau_s"]),
        "mag_learn_q16": max(1, round(65536 / (block_hz * field["learn_s"]))),
        "mag_recover_len": max(1, round(field["recover_s"] * block_hz)),
        "mag_accept_len": round(field["accept_s"] * block_hz),
        "mag_reject_len": min(65535, round(field["reject_s"] * block_hz)),
        "moving_min": round(field["moving_deg_s"] * sensor["gyro_counts_per_deg_s"]),
        "steps": steps,
        "mode": MODES.index(mode),
        "integral": round(2 * ki / kp / gyro_rad_s * 2**5),
    }
    lawful = {
        "gyro_q33": 1 <= fields["gyro_q33"] <= GYRO_Q33_MAX,
        "steps": fields["steps"] <= 255,
        "lowpass_q16": (mode == "second_order") == (1 <= fields["lowpass_q16"] <= 4095),
        "correct_q18": fields["correct_q18"] <= CORRECT_Q18_MAX,
        "ramp_mask": fields["ramp_mask"] <= RAMP_MASK_MAX,
        "gap_max": fields["gap_max"] <= GAP_MAX,
        "integral": fields["integral"] <= 32767,
        "acc_one_g": fields["acc_one_g"] <= 32767,
        "mag_learn_q16": fields["mag_learn_q16"] <= 32767,
        "moving_min": fields["moving_min"] <= 32767,
        "mag_accept_len": fields["mag_accept_len"] <= 65535,
    }
    broken = [f"{name} {fields[name]}" for name, holds in lawful.items() if not holds]
    if broken:
        raise ValueError(f"at {rate_hz} Hz mahony.h's contract is broken by {', '.join(broken)}")
    return fields


@cache
def spec() -> dict:
    """mahony.toml, whole."""
    folder = INSTALLED if INSTALLED.is_dir() else CHECKOUT
    return tomllib.loads((folder / "mahony.toml").read_text(encoding="utf-8"))


TABLES = ("second_order", *MODES[1:], "start", "field", "sensor")


def config_at(rate_hz: float, mode: str = "second_order", *, mag_rate_hz=None, **changed) -> dict:
    """Fields of mahony_config_t at any rate; `changed` are keys of mahony.toml with another value,
    those of the mode before those that all modes share."""
    tables = {name: dict(spec()[name]) for name in TABLES}
    for key, value in changed.items():
        homes = [tables[name] for name in (mode, *TABLES) if key in tables[name]]
        if not homes:
            raise ValueError(f"mahony.toml has no {key}")
        homes[0][key] = value
    return config(rate_hz, mode, mag_rate_hz=mag_rate_hz, **tables)


def named(name: str) -> dict:
    """Fields of a [[config]] of mahony.toml."""
    for entry in spec()["config"]:
        if entry["name"] == name:
            return config_at(entry["rate_hz"], entry.get("mode", "second_order"))
    known = ", ".join(entry["name"] for entry in spec()["config"])
    raise ValueError(f"no configuration {name!r}; there are {known}")
