# SPDX-License-Identifier: MIT
"""What makes the chip run the learnt detector at both of its rates: its golden vectors."""

from __future__ import annotations

from target_vectors import avr_zupt_gru
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import golden


def drive(core: AvrCore) -> None:
    """Feet, vectors of any size and edges, at both rates."""
    for vector in golden("zupt_gru_"):
        avr_zupt_gru.run(core, vector)


def drive_steps(core: AvrCore) -> None:
    """Whole steps, of vectors of any size and of feet."""
    avr_zupt_gru.zupt_gru_init(core, 1)
    for vector in golden("zupt_gru_"):
        avr_zupt_gru.zupt_gru_steps(core, avr_zupt_gru.samples_of(vector))
