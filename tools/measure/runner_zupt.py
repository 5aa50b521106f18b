# SPDX-License-Identifier: MIT
"""What makes the chip look for zero velocity with each detector: their golden vectors."""

from __future__ import annotations

from target_vectors import avr_zupt
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import golden

SAMPLES = 700  # of each: stances and swings


def drive(core: AvrCore) -> None:
    """Feet, edges, rails, configurations at their bounds."""
    for vector in golden("zupt_[!g]"):
        avr_zupt.zupt_init(core, avr_zupt.config_of(vector))
        avr_zupt.zupt(core, avr_zupt.samples_of(vector)[:SAMPLES])
