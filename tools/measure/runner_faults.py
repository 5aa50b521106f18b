# SPDX-License-Identifier: MIT
"""What makes the chip run faults with all sorts of events: its golden vectors."""

from __future__ import annotations

from target_vectors import avr_faults
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import golden


def drive(core: AvrCore) -> None:
    """Runs that end in every way, spikes, steps, noise about the limit."""
    for vector in golden("faults_"):
        rows = zip(vector["event"], vector["counts"], strict=True)
        avr_faults.faults(core, vector.parameter("noise_counts"), rows)
