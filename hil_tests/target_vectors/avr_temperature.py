# SPDX-License-Identifier: MIT
"""temperature as it runs on the chip; the wire is described in ``runner_temperature.c``."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping

from target_vectors.avr_core import AvrCore

CONFIG = struct.Struct("<ihhhB")
FIELDS = ("origin_counts", "reference_centi", "zero_counts_per_k_q4", "span_ppm_per_k_q4", "on")


def temperature_init(core: AvrCore, config: Mapping[str, int]) -> bool:
    """Whether the chip takes the configuration."""
    return bool(core.request("i", CONFIG.pack(*(config[field] for field in FIELDS)))[0])


def temperature(
    core: AvrCore, rows: Iterable[tuple[int | None, int]]
) -> list[tuple[int | None, int]]:
    """(temperature, corrected) of rows (reading before the sample or None, raw)."""
    results, now = [], None
    for reading, raw in rows:
        if reading is not None:
            known, centi = struct.unpack("<Bh", core.request("u", struct.pack("<h", reading)))
            now = centi if known else None
        corrected = core.request("c", struct.pack("<i", raw))
        results.append((now, *struct.unpack("<i", corrected)))
    return results


def temperature_counts(core: AvrCore) -> tuple[int, ...]:
    """Readings refused, results clipped."""
    return struct.unpack("<HH", core.request("n"))
