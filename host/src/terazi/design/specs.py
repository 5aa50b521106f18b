# SPDX-License-Identifier: MIT
"""shared_c/spec as numbers: designs and schedules by name or index."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path

from terazi.design import fir, weight_kf, windows

INSTALLED = Path(__file__).with_name("specs")
CHECKOUT = Path(__file__).resolve().parents[4] / "shared_c" / "spec"


@cache
def _content(name: str) -> dict:
    """A spec; a wheel carries the specs, a checkout has them in shared_c."""
    folder = INSTALLED if INSTALLED.is_dir() else CHECKOUT
    return tomllib.loads((folder / f"{name}.toml").read_text(encoding="utf-8"))


def _entries(name: str, key: str) -> tuple[dict, ...]:
    """A spec's list of tables."""
    return tuple(_content(name)[key])


def _chosen(choice: str | int, entries: tuple[dict, ...], what: str) -> dict:
    for index, entry in enumerate(entries):
        if choice in (index, entry["name"]):
            return entry
    raise ValueError(f"no {what} {choice!r}; there are {', '.join(e['name'] for e in entries)}")


def fir_designs() -> tuple[dict, ...]:
    """[[design]] of fir.toml, in order of index."""
    return _entries("fir", "design")


def fir_design(choice: str | int) -> dict:
    """One [[design]] of fir.toml."""
    return _chosen(choice, fir_designs(), "FIR design")


def fir_taps(choice: str | int):
    """(N,) float64: the design's coefficients before they are quantised."""
    design = fir_design(choice)
    if design["method"] == "frequency_sampling":
        magnitudes = [1.0] * design["passband_bins"] + list(design["transition"])
        return fir.frequency_sampling(design["taps"], magnitudes)
    if design["method"] in windows.WINDOWS:
        rate_hz = design["nominal_rate_hz"]
        return windows.lowpass(design["method"], design["taps"], design["cutoff_hz"], rate_hz)
    raise ValueError(f"{design['name']}: unknown method {design['method']}")


def fir_taps_q15(choice: str | int):
    """(N,) int64: the coefficients that the C has."""
    return fir.quantise_q15(fir_taps(choice))


def weight_kf_schedules() -> tuple[dict, ...]:
    """[[schedule]] of weight_kf.toml, in order of index."""
    return _entries("weight_kf", "schedule")


def weight_kf_schedule(choice: str | int) -> dict:
    """One [[schedule]] of weight_kf.toml."""
    return _chosen(choice, weight_kf_schedules(), "gain schedule")


def weight_kf_gains(choice: str | int) -> list[float]:
    """The schedule's gains before they are quantised, as many as the C has."""
    schedule = weight_kf_schedule(choice)
    keys = ("process_var", "noise_var", "initial_var", "steady_within", "length")
    return weight_kf.gain_schedule(**{key: schedule[key] for key in keys if key in schedule})


def weight_kf_gains_q15(choice: str | int) -> list[int]:
    """The gains that the C has; the last one is held."""
    return weight_kf.quantise_q15(weight_kf_gains(choice))


def weight_kf_adaptive_variants() -> tuple[dict, ...]:
    """[[variant]] of weight_kf_adaptive.toml, in order of index."""
    return _entries("weight_kf_adaptive", "variant")


def weight_kf_adaptive_variant(choice: str | int) -> dict:
    """One [[variant]] of weight_kf_adaptive.toml."""
    return _chosen(choice, weight_kf_adaptive_variants(), "adaptive variant")


def weight_kf_adaptive_law() -> dict:
    """[law] of weight_kf_adaptive.toml: what all variants share."""
    return _content("weight_kf_adaptive")["law"]


def weight_kf_adaptive_config(choice: str | int) -> dict[str, int]:
    """The variant's numbers as the C has them, by field of its config."""
    variant = weight_kf_adaptive_variant(choice)
    noises = ("noise", "noise_min", "noise_max")
    return {
        "process_var_q16": round(variant["process_var"] * 65536),
        **{f"{name}_q8": round(variant[name] * 256) for name in noises},
    }
