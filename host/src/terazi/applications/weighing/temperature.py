# SPDX-License-Identifier: MIT
"""Temperature drift of zero and span from a recorded run, as settings of the device.

A run is two series, each with the thermometer's reading beside the raw counts, while the room
warms or cools: one with nothing on the scale, and one, which may be missing, with one and the same
mass on it. The device must not correct while it is recorded. numpy only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from terazi.design.temperature import limits
from terazi.errors import TeraziError
from terazi.models import temperature as model

SAMPLES_MIN = 8
ZERO_MAX_Q4 = (1 << 15) - 1


class TemperatureRunRefused(TeraziError):
    """The run does not say what the drifts are."""


@dataclass(frozen=True)
class Residual:
    """How far a series strays from its own mean, in raw counts."""

    before_rms: float
    after_rms: float
    before_span: float  # greatest less least
    after_span: float


@dataclass(frozen=True)
class TemperatureFit:
    """Drifts as the device can hold them, and what they leave of the run."""

    settings: dict[str, int]  # fields of temperature_config_t but `on`
    zero_counts_per_k: float
    span_ppm_per_k: float  # 0 without a series with a mass on
    reference_c: float
    moved_k: float  # least of the series
    empty: Residual
    loaded: Residual | None

    @property
    def helps(self) -> bool:
        """Less is left than there was, in every series."""
        series = [each for each in (self.empty, self.loaded) if each]
        return all(each.after_rms < each.before_rms for each in series)


def _series(temperature_c, counts, what: str) -> tuple[np.ndarray, np.ndarray]:
    warm, raw = (np.asarray(each, dtype=np.float64) for each in (temperature_c, counts))
    if warm.ndim != 1 or warm.shape != raw.shape:
        raise ValueError(f"{what}: temperatures and counts differ in length")
    if not (np.isfinite(warm).all() and np.isfinite(raw).all()):
        raise ValueError(f"{what}: not a number among temperatures or counts")
    if len(warm) < SAMPLES_MIN:
        raise TemperatureRunRefused(
            f"{what}: {len(warm)} samples, at least {SAMPLES_MIN} are needed",
            remedy="record for longer",
        )
    moved_k, least_k = float(np.ptp(warm)), limits()["moved_min_k"]
    if moved_k < least_k:
        raise TemperatureRunRefused(
            f"{what}: the temperature moved by {moved_k:.1f} K, at least {least_k:g} K are needed",
            remedy="warm or cool the scale slowly while it records, by a heater or a window",
        )
    return warm, raw


def _residual(raw: np.ndarray, corrected: np.ndarray) -> Residual:
    return Residual(
        *(float(np.std(each)) for each in (raw, corrected)),
        *(float(np.ptp(each)) for each in (raw, corrected)),
    )


def _held(name: str, value: float, bound_q4: int) -> int:
    """value in Q4, refused where the device cannot hold it."""
    held = round(value * 16)
    if abs(held) > bound_q4:
        raise TemperatureRunRefused(
            f"{name} would be {value:.1f}, beyond {bound_q4 / 16:g}: no load cell drifts so much",
            remedy="look for a load that moved, or a cable that warmed, during the run",
        )
    return held


def fit(
    empty_c, empty_counts, loaded_c=None, loaded_counts=None, *, reference_c: float | None = None
) -> TemperatureFit:
    """Zero's and span's drift by least squares, both together.

    empty_c, loaded_c : (n,) thermometer, degC, beside each of
    empty_counts, loaded_counts : (n,) raw counts with nothing on and with a mass on.
    reference_c : temperature that everything is corrected to; None: the middle of the run.

    Solves c - zero dT - span dT (c - origin) = constant, the form of temperature.h, with one
    constant a series, so that what the device computes is what was fitted.
    """
    warm, raw = _series(empty_c, empty_counts, "with nothing on")
    moved_k = float(np.ptp(warm))
    both_warm, both_raw, loaded = warm, raw, np.zeros(len(raw), dtype=bool)
    if loaded_c is not None:
        loaded_warm, loaded_raw = _series(loaded_c, loaded_counts, "with the mass on")
        moved_k = min(moved_k, float(np.ptp(loaded_warm)))
        both_warm = np.concatenate([warm, loaded_warm])
        both_raw = np.concatenate([raw, loaded_raw])
        loaded = np.arange(len(both_raw)) >= len(raw)
    if reference_c is None:
        reference_c = float(both_warm.min() + both_warm.max()) / 2
    reference_centi = round(reference_c * 100)
    above_k = both_warm - reference_centi / 100

    slope, origin = np.polyfit(above_k[~loaded], raw, 1)
    origin_counts = round(float(origin))
    columns = [~loaded, above_k]
    if loaded.any():
        load = float(both_raw[loaded].mean() - raw.mean())
        if abs(load) < 10 * np.std(raw - slope * above_k[~loaded]):
            raise TemperatureRunRefused(
                "the mass can hardly be told from nothing",
                remedy="record with at least a quarter of what the scale can bear",
            )
        columns += [loaded, above_k * (both_raw - origin_counts) * 1e-6]
    solution = np.linalg.lstsq(np.column_stack(columns).astype(float), both_raw, rcond=None)[0]

    span_max_q4 = limits()["span_max_ppm_per_k"] * 16
    zero_q4 = _held("the zero's drift in counts a kelvin", solution[1], ZERO_MAX_Q4)
    span_q4 = 0
    if loaded.any():
        span_q4 = _held("the span's drift in ppm a kelvin", solution[3], span_max_q4)
    corrected = model.correct(
        both_raw,
        above_k,
        zero_counts_per_k=zero_q4 / 16,
        span_ppm_per_k=span_q4 / 16,
        origin_counts=origin_counts,
    )
    return TemperatureFit(
        settings={
            "origin_counts": origin_counts,
            "reference_centi": reference_centi,
            "zero_counts_per_k_q4": zero_q4,
            "span_ppm_per_k_q4": span_q4,
        },
        zero_counts_per_k=zero_q4 / 16,
        span_ppm_per_k=span_q4 / 16,
        reference_c=reference_centi / 100,
        moved_k=moved_k,
        empty=_residual(raw, corrected[~loaded]),
        loaded=_residual(both_raw[loaded], corrected[loaded]) if loaded.any() else None,
    )
