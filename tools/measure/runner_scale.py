# SPDX-License-Identifier: MIT
"""What makes the chip run scale with all sorts of data: its golden vectors."""

from __future__ import annotations

from target_vectors import avr_scale
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import Vector, golden


def config_of(vector: Vector) -> dict:
    """Fields of scale_config_t."""
    fields = {}
    for field, layout in avr_scale.SCALE_LAYOUT.items():
        if field == "spare":
            continue
        words = [int(word) for word in vector.parameters[field].split()]
        fields[field] = words if len(layout) > 1 else words[0]
    return fields


def drive_scale(core: AvrCore) -> None:
    """Usual days, bounds of the configuration, all units."""
    for vector in golden("scale_"):
        if avr_scale.scale_init(core, config_of(vector)) != 0:
            raise ValueError(f"the chip refuses the configuration of {vector}")
        columns = (vector[name] for name in ("command", "argument", "counts", "device_us"))
        avr_scale.scale(core, zip(*columns, strict=True))
