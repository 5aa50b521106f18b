# SPDX-License-Identifier: MIT
"""What makes the chip run mahony: its golden vectors, after the start, which happens once."""

from __future__ import annotations

from target_vectors import avr_mahony
from target_vectors.avr_core import AvrCore
from terazi.design import mahony as design
from terazi.models.vectors import golden

INPUTS = (
    "gap_samples",
    *(f"{sensor}_{axis}_counts" for sensor in ("gyro", "acc", "mag") for axis in "xyz"),
    *(f"bias_{axis}_q16" for axis in "xyz"),
)
STARTED = (0, 0, 0, 0, 30, -40, 2048, 300, 2000, -4500, 0, 0, 0)
VECTORS = ("mahony_rest", "mahony_fast", "mahony_heading", "mahony_pitch", "mahony_magnet")


def prepare(core: AvrCore) -> None:
    """Start, and run through the ramp's first half, attitude and heading being set."""
    avr_mahony.mahony(core, design.named("286hz"), [STARTED] * 300, axes=9)


def drive(core: AvrCore) -> None:
    """At rest, swung, through the lock of pitch, near a magnet; the ramp ends on the way."""
    for name in VECTORS:
        (vector,) = golden(name)
        rows = zip(*(vector[column] for column in INPUTS), strict=True)
        avr_mahony.go_on(core, [(0, *row[1:]) for row in rows])
