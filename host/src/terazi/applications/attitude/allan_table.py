# SPDX-License-Identifier: MIT
"""The figures of an Allan deviation as rows of text, for the terminal and the page alike."""

from __future__ import annotations

import math

from terazi.applications.attitude.allan import (
    DATASHEET_ACC_G_RTHZ,
    DATASHEET_GYRO_DEG_S_RTHZ,
    HOUR_S,
    Allan,
    Axis,
    velocity_walk,
)

HEADINGS = {  # with their units below
    "gyro": (
        "gyroscope",
        "density\ndeg/s/√Hz",
        "angle\nrandom walk\ndeg/√h",
        "bias\ninstability\ndeg/h",
        "at\ns",
        "rate\nrandom walk\ndeg/h/√h",
    ),
    "acc": (
        "accelerometer",
        "density\nug/√Hz",
        "velocity\nrandom walk\nm/s/√h",
        "bias\ninstability\nug",
        "at\ns",
        "acceleration\nrandom walk\nug/√s",
    ),
}
NONE = "–"


def gyro_rows(found: Allan) -> list[list[str]]:
    """An axis a row, and the datasheet's."""
    rows = [
        _row(name, axis, 1.0, math.sqrt(HOUR_S), HOUR_S, HOUR_S**1.5)
        for name, axis in found.gyro.items()
    ]
    density = DATASHEET_GYRO_DEG_S_RTHZ
    walk = density / math.sqrt(2) * math.sqrt(HOUR_S)
    return [*rows, ["datasheet", f"{density:.3g}", f"{walk:.3g}", NONE, NONE, NONE]]


def acc_rows(found: Allan) -> list[list[str]]:
    """An axis a row, and the datasheet's."""
    rows = [_row(name, axis, 1e6, velocity_walk(1.0), 1e6, 1e6) for name, axis in found.acc.items()]
    density = DATASHEET_ACC_G_RTHZ
    walk = velocity_walk(density / math.sqrt(2))
    return [*rows, ["datasheet", f"{density * 1e6:.3g}", f"{walk:.3g}", NONE, NONE, NONE]]


def _row(name: str, axis: Axis, density: float, white: float, bias: float, walk: float) -> list:
    """The arguments after the axis are what makes of its units those of the headings."""
    below = "" if axis.instability_is_seen else "< "
    return [
        name,
        _figure(axis.density, density),
        _figure(axis.white, white),
        f"{below}{axis.instability * bias:.3g}",
        f"{axis.instability_tau_s:.3g}",
        _figure(axis.walk, walk),
    ]


def _figure(value: float | None, scale: float) -> str:
    return NONE if value is None else f"{value * scale:.3g}"
