# SPDX-License-Identifier: MIT
"""The page of `terazi weigh FILE`: errors beside class III, readings over time, tables."""

from __future__ import annotations

import html
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

from terazi.applications.weighing.limits import IN_SERVICE, permitted_error_e
from terazi.applications.weighing.points import Placement, Point, Weighing
from terazi.recorder.recording import Recording
from terazi.report import parts
from terazi.report.analysis import Analysis
from terazi.report.figures import COLOURS, level, style, thinned

LIMIT_COLOUR = "#d1495b"
EDGES_E = (0.0, 500.0, 2000.0)  # where class III's limits change


def write_weighing(
    path: Path, recording: Recording, analysis: Analysis, weighing: Weighing
) -> None:
    """Write the page, whole or not at all. Raises CannotWrite."""
    parts.write_page(path, render(recording, analysis, weighing))


def render(recording: Recording, analysis: Analysis, weighing: Weighing) -> str:
    """The page's text."""
    is_known = weighing.points[0].is_known
    return parts.page_of(
        f"Terazi weighs: {recording.path.name}",
        [
            _heading(recording, weighing),
            _cards(weighing),
            parts.section("Errors and class III", parts.plot(errors(weighing)), _limits_note())
            if is_known
            else "",
            parts.section("Load points", _points_table(weighing), _points_note(weighing)),
            parts.section("Readings", parts.plot(readings(analysis, weighing))),
            parts.section("Placements", _placements_table(weighing)),
            parts.footer(),
        ],
    )


def limit_steps(max_e: float) -> tuple[np.ndarray, np.ndarray]:
    """Corners of class III's limit from 0 to max_e: loads and limits in e."""
    edges = [edge for edge in EDGES_E if edge < max_e] + [max_e]
    loads = np.repeat(edges, 2)[1:-1]
    limits = permitted_error_e(np.repeat([edge for edge in edges[1:]], 2))
    return loads, limits


def errors(weighing: Weighing) -> go.Figure:
    """Each reading's error over its load, between the limits."""
    figure = go.Figure()
    most_e = max(point.load_g for point in weighing.points) / weighing.e_g
    loads, limits = limit_steps(max(most_e, 1.0))
    for factor, dash, name in ((1.0, "solid", "verification"), (IN_SERVICE, "dot", "in service")):
        for sign in (1.0, -1.0):
            figure.add_trace(
                go.Scatter(
                    x=loads,
                    y=sign * factor * limits,
                    mode="lines",
                    name=f"class III, {name}",
                    legendgroup=name,
                    showlegend=sign > 0,
                    line={"color": LIMIT_COLOUR, "width": 1.4, "dash": dash},
                    hoverinfo="skip",
                )
            )
    for direction, symbol, colour in (
        ("first", "circle", COLOURS["raw"]),
        ("up", "triangle-up", COLOURS["kalman"]),
        ("down", "triangle-down", COLOURS["fir"]),
    ):
        here = [one for one in weighing.placements if one.direction == direction]
        loads_g = [_load_of(weighing, one) for one in here]
        if here:
            figure.add_trace(
                go.Scatter(
                    x=np.array(loads_g) / weighing.e_g,
                    y=[
                        (one.reading_g - load) / weighing.e_g
                        for one, load in zip(here, loads_g, strict=True)
                    ],
                    error_y={"type": "data", "array": [one.sigma_g / weighing.e_g for one in here]},
                    mode="markers",
                    name="first" if direction == "first" else f"going {direction}",
                    marker={"color": colour, "symbol": symbol, "size": 10},
                )
            )
    style(figure, height=430)
    figure.update_layout(hovermode="closest")
    figure.update_xaxes(title_text="load / e")
    figure.update_yaxes(title_text="error / e")
    return figure


def readings(analysis: Analysis, weighing: Weighing) -> go.Figure:
    """What was weighed over time, and the stretches that count."""
    figure = go.Figure()
    t_s, values_g = thinned(analysis.t_s, analysis.stages_g["kalman"])
    figure.add_trace(
        go.Scatter(x=t_s, y=values_g, mode="lines", name="weight", line={"color": COLOURS["raw"]})
    )
    x: list[float | None] = []
    y: list[float | None] = []
    for one in weighing.placements:
        x += [float(analysis.t_s[one.begin]), float(analysis.t_s[one.end - 1]), None]
        y += [one.reading_g, one.reading_g, None]
    figure.add_trace(
        go.Scatter(
            x=x, y=y, mode="lines", name="readings", line={"color": COLOURS["kalman"], "width": 5}
        )
    )
    style(figure, height=360)
    figure.update_xaxes(title_text="device time since the first sample / s")
    figure.update_yaxes(title_text="weight / g")
    return figure


def _load_of(weighing: Weighing, one: Placement) -> float:
    """The load of a placement, by its nearest point."""
    return min((point.load_g for point in weighing.points), key=lambda g: abs(g - one.reading_g))


def _heading(recording: Recording, weighing: Weighing) -> str:
    facts = f"e = {weighing.e_g:g} g · Max = {weighing.max_g:g} g · {weighing.rate_hz:.2f} SPS"
    return (
        f'<header><h1>{html.escape(recording.path.name)}</h1><p class="facts">{facts}</p></header>'
    )


def _cards(weighing: Weighing) -> str:
    placements, points = weighing.placements, weighing.points
    cards = [
        (str(len(points)), "load points", False),
        (str(len(placements)), "placements", False),
        (f"{max(point.sigma_e for point in points):.3f} e", "greatest sigma", False),
        (f"{max(point.repeatability_e for point in points):.3f} e", "repeatability", False),
    ]
    if weighing.within is not None:
        worst_e = max(point.worst_error_e for point in points)
        cards.insert(0, (f"{worst_e:.3f} e", "worst error", not weighing.within))
        verdict = "within" if weighing.within else "outside"
        cards.insert(0, (verdict, "class III at verification", not weighing.within))
    unstable = sum(not one.is_stable for one in placements)
    if unstable:
        cards.append((str(unstable), "never stable", True))
    boxes = [
        f'<div class="card{" bad" if bad else ""}"><b>{value}</b><span>{label}</span></div>'
        for value, label, bad in cards
    ]
    return '<div class="cards">' + "".join(boxes) + "</div>"


def _e(value: float | None, digits: int = 3, *, sign: bool = False) -> str:
    if value is None or not np.isfinite(value):
        return "–"
    return f"{value:+.{digits}f}" if sign else f"{value:.{digits}f}"


def _verdict(point: Point) -> str:
    if point.within is None:
        return "–"
    if point.within:
        return "within"
    words = "in service only" if point.within_in_service else "outside"
    return f'<span class="never">{words}</span>'


def _points_table(weighing: Weighing) -> str:
    head = [
        "load", "placements", "mean error", "worst", "class III", "", "sigma", "sigma / √N",
        "repeatability", "down less up",
    ]  # fmt: skip
    rows = [
        [
            level(point.load_g, 1),
            f"{point.placements} ({point.samples} samples)",
            _e(point.mean_error_e, sign=True),
            _e(point.worst_error_e),
            f"±{point.limit_e:g} (±{point.limit_in_service_e:g})",
            _verdict(point),
            _e(point.sigma_e),
            _e(point.bound_e),
            _e(point.repeatability_e),
            _e(point.hysteresis_e, sign=True),
        ]
        for point in weighing.points
    ]
    return parts.table(head, rows)


def _points_note(weighing: Weighing) -> str:
    return parts.note(
        "All in e but the load. A placement's reading is the mean of its samples that were marked "
        "stable. Sigma: of single samples about it. Sigma / √N: what the mean of as many raw "
        "samples can be known to. The converter's own floor, by its data sheet, is "
        f"{weighing.floor_e:.3f} e a raw sample. Class III: at verification, and in service in "
        "brackets."
    )


def _limits_note() -> str:
    return parts.note(
        "Class III permits ±0.5 e to 500 e, ±1 e to 2000 e and ±1.5 e beyond; in service twice as "
        "much. Bars: one sigma of single samples."
    )


def _placements_table(weighing: Weighing) -> str:
    rows = [
        [
            f"{one.t_s:.2f} s",
            level(one.reading_g, 3),
            f"{one.samples}",
            one.direction,
            "never" if not one.is_stable else _seconds(one.stable_after_s),
        ]
        for one in weighing.placements
    ]
    return parts.table(["from", "reading", "samples", "", "stable after"], rows)


def _seconds(time_s: float | None) -> str:
    return "–" if time_s is None else f"{time_s:.3f} s"
