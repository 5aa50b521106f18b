# SPDX-License-Identifier: MIT
"""What makes the chip correct counts at all sorts of temperatures: the golden vectors."""

from __future__ import annotations

from target_vectors import avr_temperature
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import golden

SAMPLES = 40


def drive(core: AvrCore) -> None:
    """Warm, cold, at the bounds, switched off."""
    for vector in golden("temperature_"):
        config = {field: vector.parameter(field) for field in avr_temperature.FIELDS}
        avr_temperature.temperature_init(core, config)
        rows = list(zip(vector["measured_centi"], vector["raw_counts"], strict=True))
        avr_temperature.temperature(core, rows[-SAMPLES:])
