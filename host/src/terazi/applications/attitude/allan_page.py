# SPDX-License-Identifier: MIT
"""The page of `terazi attitude allan`: a curve per axis, and what is read off it."""

from __future__ import annotations

import html
import math
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

from terazi.applications.attitude.allan import (
    AXES,
    DATASHEET_ACC_G_RTHZ,
    DATASHEET_GYRO_DEG_S_RTHZ,
    FLAT,
    HOUR_S,
    READ_SHARE,
    Allan,
    Axis,
)
from terazi.applications.attitude.allan_table import HEADINGS, acc_rows, gyro_rows
from terazi.report import parts
from terazi.report.figures import INK, style

COLOURS = dict(zip(AXES, ("#e69f00", "#12a37a", "#3d8fe0"), strict=True))


def write_allan(path: Path, found: Allan) -> None:
    """Write the page, whole or not at all. Raises CannotWrite."""
    parts.write_page(path, render(found))


def render(found: Allan) -> str:
    """The page's text."""
    facts = f"{found.duration_s:.0f} s at {found.rate_hz:g} samples a second"
    heading = f'<header><h1>{html.escape(found.name)}</h1><p class="facts">{facts}</p>'
    warnings = (f'<p class="warning">{html.escape(note)}</p>' for note in found.notes)
    return parts.page_of(
        f"Allan deviation: {found.name}",
        [
            heading + "".join(warnings) + "</header>",
            parts.section(
                "Gyroscope",
                parts.plot(_curves(found.gyro, HOUR_S, "deg/h", DATASHEET_GYRO_DEG_S_RTHZ)),
                parts.table(_head("gyro"), gyro_rows(found)),
            ),
            parts.section(
                "Accelerometer",
                parts.plot(_curves(found.acc, 1e6, "ug", DATASHEET_ACC_G_RTHZ)),
                parts.table(_head("acc"), acc_rows(found)),
            ),
            parts.note(
                "Overlapping Allan deviation, figures after IEEE Std 952. The dashed line is the "
                "datasheet's noise (MPU-6050, 0.005 deg/s/√Hz and 400 ug/√Hz, one-sided: √2 times "
                "the random walk's coefficient). The least of a curve is its bias instability, "
                f"over {FLAT:.3f}; a “<” says that the curve still falls, so that a longer record "
                f"would show less. Averages of more than 1/{READ_SHARE} of the record are drawn "
                "but not read off."
            ),
            parts.footer(),
        ],
    )


def _head(sensor: str) -> list[str]:
    return [heading.replace("\n", "<br>") for heading in HEADINGS[sensor]]


def _curves(axes: dict[str, Axis], scale: float, unit: str, density: float) -> go.Figure:
    figure = go.Figure()
    for name, axis in axes.items():
        y = axis.deviation * scale
        trace = go.Scatter(
            x=axis.tau_s,
            y=y,
            error_y={"array": axis.error * scale, "thickness": 0.8, "width": 0},
            mode="lines",
            name=name,
            line={"color": COLOURS[name], "width": 2},
        )
        figure.add_trace(trace)
    tau_s = next(iter(axes.values())).tau_s[[0, -1]]
    figure.add_trace(
        go.Scatter(
            x=tau_s,
            y=density / math.sqrt(2) / np.sqrt(tau_s) * scale,
            mode="lines",
            name="datasheet",
            line={"color": INK, "dash": "dash", "width": 1.4},
        )
    )
    style(figure, height=430)
    figure.update_layout(hovermode="closest")
    figure.update_xaxes(title_text="averaged over / s", type="log", exponentformat="power")
    figure.update_yaxes(
        title_text=f"Allan deviation / ({unit})", type="log", exponentformat="power"
    )
    return figure
