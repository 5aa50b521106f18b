# SPDX-License-Identifier: MIT
"""What makes the chip run scale and checkweigher with all sorts of data: golden vectors."""

from __future__ import annotations

from target_vectors import avr_scale
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import Vector, golden


def _fields(vector: Vector, layouts: dict[str, str]) -> dict:
    fields = {}
    for field, layout in layouts.items():
        if field == "spare":
            continue
        words = [int(word) for word in vector.parameters[field].split()]
        fields[field] = words if len(layout) > 1 else words[0]
    return fields


def config_of(vector: Vector) -> dict:
    """Fields of scale_config_t."""
    return _fields(vector, avr_scale.SCALE_LAYOUT)


def checkweigher_config_of(vector: Vector) -> dict:
    """Fields of checkweigher_config_t."""
    return _fields(vector, avr_scale.CHECKWEIGHER_LAYOUT)


def drive_scale(core: AvrCore) -> None:
    """Usual days, bounds of the configuration, all units."""
    for vector in golden("scale_"):
        if avr_scale.scale_init(core, config_of(vector)) != 0:
            raise ValueError(f"the chip refuses the configuration of {vector}")
        columns = (vector[name] for name in ("command", "argument", "raw", "counts", "device_us"))
        avr_scale.scale(core, zip(*columns, strict=True))


def drive_checkweigher(core: AvrCore) -> None:
    """Products weighed and not, stretches of every length up to the longest."""
    for vector in golden("checkweigher_"):
        if not avr_scale.checkweigher_init(core, checkweigher_config_of(vector)):
            raise ValueError(f"the chip refuses the configuration of {vector}")
        avr_scale.checkweigher(core, zip(vector["mass_mg"], vector["device_us"], strict=True))
