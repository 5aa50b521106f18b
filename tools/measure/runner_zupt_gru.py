# SPDX-License-Identifier: MIT
"""What makes the chip run the learnt detector at both of its rates: its golden vectors."""

from __future__ import annotations

from collections.abc import Callable

from target_vectors import avr_zupt_gru
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import golden


def drive(sample_ms: int) -> Callable[[AvrCore], None]:
    """Feet, vectors of any size and edges, as many as there are at that rate."""

    def run(core: AvrCore) -> None:
        for vector in golden("zupt_gru_"):
            if vector.parameter("sample_ms") == sample_ms:
                avr_zupt_gru.run(core, vector)

    return run
