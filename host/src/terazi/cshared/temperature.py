# SPDX-License-Identifier: MIT
"""temperature of shared_c for numpy and, step by step, for Python."""

from __future__ import annotations

import numpy as np

from terazi.cshared._cshared import ffi, lib
from terazi.cshared.state import CState

COUNTS_MIN, COUNTS_MAX = -(1 << 23), (1 << 23) - 1


class Temperature(CState):
    """Temperature compensation of raw counts (temperature.h).

    Fields of temperature_config_t by name; terazi.applications.weighing.temperature fits them.
    """

    def __init__(
        self,
        *,
        origin_counts: int = 0,
        reference_centi: int = 2000,
        zero_counts_per_k_q4: int = 0,
        span_ppm_per_k_q4: int = 0,
        on: bool = True,
    ):
        fields = {
            "origin_counts": origin_counts,
            "reference_centi": reference_centi,
            "zero_counts_per_k_q4": zero_counts_per_k_q4,
            "span_ppm_per_k_q4": span_ppm_per_k_q4,
            "on": on,
        }
        try:
            self._config = ffi.new("temperature_config_t *", fields)
        except OverflowError as error:
            raise ValueError(f"temperature compensation: {error}") from None
        if not lib.temperature_is_lawful(self._config):
            raise ValueError(
                "temperature compensation: origin, reference or span is beyond temperature.h"
            )
        self._c = ffi.new("temperature_t *")
        lib.temperature_init(self._c, self._config)

    @property
    def centi(self) -> int | None:
        """The temperature that corrections are made for, 1/100 degC; None before any reading."""
        return lib.temperature_centi(self._c) if self._c.known else None

    @property
    def refused(self) -> int:
        """Readings out of range so far, stops at 65535."""
        return self._c.refused

    @property
    def clipped(self) -> int:
        """Results beyond 24 bits so far, stops at 65535."""
        return self._c.clipped

    def update(self, measured_centi: int) -> None:
        """Take one reading of the thermometer."""
        lib.temperature_update(self._c, measured_centi)

    def correct(self, raw_counts: int) -> int:
        """One raw count of 24 bits, corrected."""
        if not COUNTS_MIN <= raw_counts <= COUNTS_MAX:
            raise ValueError(f"{raw_counts} counts do not fit in 24 bits")
        return lib.temperature_correct(self._c, raw_counts)

    def block(self, raw_counts, measured_centi=None) -> np.ndarray:
        """Correct (n,) raw counts; gives (n,) int32.

        measured_centi : (n,) float64 reading before each sample, NaN where there is none; None: no
            readings at all.
        """
        raw = np.ascontiguousarray(raw_counts, dtype=np.int32)
        if raw.ndim != 1 or not np.array_equal(raw, raw_counts):
            raise ValueError("raw counts must be a row of integers of 32 bits")
        if raw.size and not (raw.min() >= COUNTS_MIN and raw.max() <= COUNTS_MAX):
            raise ValueError("raw counts do not fit in 24 bits")
        readings = np.full(len(raw), np.nan) if measured_centi is None else measured_centi
        readings = np.asarray(readings, dtype=np.float64)
        if readings.shape != raw.shape:
            raise ValueError(f"{len(raw)} counts and readings of shape {readings.shape}")
        has = np.isfinite(readings)
        centi = np.rint(np.where(has, np.clip(readings, -32768, 32767), 0)).astype(np.int16)
        corrected = np.empty_like(raw)
        lib.temperature_blocks_correct(
            self._c,
            ffi.from_buffer("int32_t[]", raw),
            ffi.from_buffer("int16_t[]", centi),
            ffi.from_buffer("uint8_t[]", has.astype(np.uint8)),
            ffi.from_buffer("int32_t[]", corrected, require_writable=True),
            len(raw),
        )
        return corrected
