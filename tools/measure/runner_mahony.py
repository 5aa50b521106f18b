# SPDX-License-Identifier: MIT
"""What makes the chip run mahony: its golden vectors, after the start, which happens once."""

from __future__ import annotations

import random
from collections.abc import Callable

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
START_SAMPLES = 192  # of the configuration, before gains fall
STILL_SAMPLES = 2000
SEED = 11
VECTORS = ("mahony_rest", "mahony_fast", "mahony_heading", "mahony_pitch", "mahony_magnet")


def prepare(core: AvrCore) -> None:
    """Start, and run through the ramp's first half, attitude and heading being set."""
    avr_mahony.mahony(core, design.named("286hz"), [STARTED] * 600, axes=9)


def prepare_chain(axes: int) -> Callable[[AvrCore], None]:
    """Start rest and mahony by the same sample, as a device does, and stand up. What comes is the
    ramp and all that follows."""

    def prepare_axes(core: AvrCore) -> None:
        avr_mahony.mahony(core, design.named("286hz"), [STARTED], axes=axes)
        avr_mahony.start_chain(core)
        avr_mahony.chain(core, [STARTED] * START_SAMPLES)

    return prepare_axes


def drive_chain(core: AvrCore) -> None:
    """Still for 7 s, so that rest learns while gains fall and after; then as `drive`."""
    rng = random.Random(SEED)
    still = [
        (0, *(value + rng.randint(-3, 3) for value in STARTED[1:10]), 0, 0, 0)
        for _ in range(STILL_SAMPLES)
    ]
    avr_mahony.chain(core, still + vector_rows())


def drive(core: AvrCore) -> None:
    """At rest, swung, through the lock of pitch, near a magnet; the ramp ends on the way."""
    avr_mahony.go_on(core, vector_rows())


def vector_rows() -> list[tuple[int, ...]]:
    """The vectors' samples one after the other, without their gaps."""
    rows: list[tuple[int, ...]] = []
    for name in VECTORS:
        (vector,) = golden(name)
        columns = zip(*(vector[column] for column in INPUTS), strict=True)
        rows += [(0, *row[1:]) for row in columns]
    return rows
