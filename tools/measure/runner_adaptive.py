# SPDX-License-Identifier: MIT
"""What makes the chip run weight_kf_adaptive with all sorts of data: its golden vectors."""

from __future__ import annotations

from target_vectors import avr_adaptive
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import golden


def _drive(core: AvrCore, *, pair: bool) -> None:
    for vector in golden("weight_kf_adaptive_"):
        if vector.parameter("pair") == pair:
            variant, first = vector.parameter("variant"), vector.parameter("first_counts")
            avr_adaptive.adaptive(core, variant, first, vector["measured_counts"], pair=pair)


def drive_single(core: AvrCore) -> None:
    """Rest, steps, spikes, rails."""
    _drive(core, pair=False)


def drive_pair(core: AvrCore) -> None:
    """The same for the two models."""
    _drive(core, pair=True)
