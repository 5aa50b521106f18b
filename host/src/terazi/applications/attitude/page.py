# SPDX-License-Identifier: MIT
"""The page of `terazi attitude FILE`: angles, rates, bias, rest, field and errors over time."""

from __future__ import annotations

import html
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

from terazi.applications.attitude.summary import ANGLES, FLAG_WORDS, rows
from terazi.applications.attitude.view import View
from terazi.report import parts
from terazi.report.figures import GRID, INK, POINTS_SHOWN, style, thinned
from terazi.units import show_duration

COLOURS = ("#e69f00", "#12a37a", "#3d8fe0")  # x y z, roll pitch yaw
ALARM = "#d1495b"
BARS = {  # flags in the order of the plot, uppermost last
    "railed": ALARM,
    "restarted": ALARM,
    "gap": ALARM,
    "disturbed": "#b07cc6",
    "heading": "#3d8fe0",
    "bias_known": INK,
    "still": "#e69f00",
    "rest": "#12a37a",
}
BARS_SHOWN = 2000
NOTE = "Drag to zoom, double-click to see all, click a name to hide it."
HALF_TURN_DEG = 180.0  # angles over more are told by quarters


def write_view(path: Path, view: View) -> None:
    """Write the page, whole or not at all. Raises CannotWrite."""
    parts.write_page(path, render(view))


def render(view: View) -> str:
    """The page's text."""
    return parts.page_of(
        f"Attitude: {view.name}",
        [
            _heading(view),
            _cards(view),
            parts.section("Angles", parts.plot(_angles(view)), parts.note(_angle_note(view))),
            _flags_section(view),
            parts.section("Rates", parts.plot(_rates(view)), parts.note(_rate_note(view))),
            _bias_section(view),
            _acceleration_section(view),
            _field_section(view),
            _error_section(view),
            parts.section("Figures", parts.table(["", ""], [_cells(row) for row in rows(view)])),
            parts.footer(),
        ],
    )


def _cells(row: tuple[str, str]) -> list[str]:
    return [html.escape(cell) for cell in row]


def _heading(view: View) -> str:
    lines = [
        f"<header><h1>{html.escape(view.name)}</h1>",
        f'<p class="facts">attitudes: {html.escape(view.source)}</p>',
        *(f'<p class="warning">{html.escape(note)}</p>' for note in view.notes),
        "</header>",
    ]
    return "\n".join(lines)


def _cards(view: View) -> str:
    cards = [
        (show_duration(float(view.t_s[-1])), "recorded", False),
        (f"{view.rate_hz:.5g} Hz", "attitudes a second", False),
        (f"{np.median(view.tilt_deg):.2f}°", "off the vertical, median", False),
    ]
    if view.share("rest") is not None:
        cards.append((f"{view.share('rest'):.0%}", "at rest", False))
    if view.errors is not None:
        cards += [
            (f"{view.errors.inclination_rmse_deg:.2f}°", "inclination error, rms", False),
            (f"{view.errors.heading_rmse_deg:.2f}°", "heading error, rms", False),
        ]
    for name in ("gap", "railed", "restarted"):
        if view.share(name):
            count = int(np.sum(view.flags[name]))
            cards.append((str(count), f"attitudes: {FLAG_WORDS[name]}", True))
    boxes = (
        f'<div class="card{" bad" if bad else ""}"><b>{value}</b><span>{label}</span></div>'
        for value, label, bad in cards
    )
    return '<div class="cards">' + "".join(boxes) + "</div>"


def _lines(figure: go.Figure, t_s, columns, names, **look) -> None:
    for at, (name, column) in enumerate(zip(names, columns, strict=True)):
        x, y = thinned(t_s, column)
        line = {"color": COLOURS[at % 3], "width": 1.6} | look
        figure.add_trace(
            go.Scatter(x=np.round(x, 4), y=np.round(y, 5), mode="lines", name=name, line=line)
        )


def _axes(figure: go.Figure, title: str, height: int = 360) -> go.Figure:
    style(figure, height=height)
    figure.update_xaxes(title_text="time since the first attitude / s")
    figure.update_yaxes(title_text=title)
    return figure


def _angles(view: View) -> go.Figure:
    figure = go.Figure()
    _lines(figure, view.t_s, view.euler_deg.T, ANGLES)
    for trace in figure.data:
        trace.x, trace.y = _cut_at_wraps(np.asarray(trace.x), np.asarray(trace.y))
    axes = _axes(figure, "angle / deg", 430)
    if np.ptp(view.euler_deg) > HALF_TURN_DEG:
        axes.update_yaxes(dtick=90)
    return axes


def _cut_at_wraps(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """No line from one end of the circle to the other."""
    cuts = np.flatnonzero(np.abs(np.diff(y)) > 180) + 1
    return np.insert(x, cuts, x[cuts]), np.insert(y, cuts, np.nan)


def _angle_note(view: View) -> str:
    words = [NOTE, "Order z-y-x, body to world."]
    if len(view.t_s) > POINTS_SHOWN:
        words.append("Drawn from the extremes of short stretches; the figures hold every sample.")
    heading = view.share("heading")
    if (heading is None and view.heading_is_free) or heading == 0:
        words.append("Without a magnetometer yaw counts from where it began, and drifts.")
    words.append("Near pitch ±90 deg roll and yaw turn into each other; the attitude does not.")
    return " ".join(words)


def _flags_section(view: View) -> str:
    known = [name for name in BARS if name in view.flags]
    figure = go.Figure()
    for name in known:
        x, y = _bars(view.t_s, view.flags[name], FLAG_WORDS[name])
        figure.add_trace(
            go.Scatter(
                x=x,
                y=y,
                mode="lines",
                line={"color": BARS[name], "width": 11},
                showlegend=False,
                hoverinfo="x+y",
            )
        )
    _axes(figure, "", 90 + 34 * len(known))
    figure.update_layout(hovermode="closest", margin={"t": 20})
    figure.update_yaxes(type="category", categoryorder="array", gridcolor=GRID)
    figure.update_yaxes(categoryarray=[FLAG_WORDS[name] for name in known])
    figure.update_yaxes(range=[-0.6, len(known) - 0.4])
    figure.update_xaxes(range=[0, float(view.t_s[-1])])
    return parts.section("Rest and events", parts.plot(figure))


def _bars(t_s: np.ndarray, flag: np.ndarray, word: str) -> tuple[list, list]:
    """Stretches in which a flag held; what is shorter than a pixel is drawn as long as one."""
    edges = np.diff(np.concatenate([[0], flag.astype(np.int8), [0]]))
    begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    least_s = float(t_s[-1]) / BARS_SHOWN
    x: list = []
    until_s = -1.0
    for begin, end in zip(t_s[begins], t_s[ends], strict=True):
        if x and begin - until_s < least_s:
            x[-2] = until_s = max(float(end), until_s)
            continue
        until_s = max(float(end), float(begin) + least_s)
        x += [float(begin), until_s, None]
    if not x:
        x = [None]  # the row is there, empty
    return x, [word] * len(x)


def _rates(view: View) -> go.Figure:
    figure = go.Figure()
    if view.sensors is not None:
        _lines(figure, view.sensors.t_s, view.sensors.rate_b_deg_s.T, "xyz")
    else:
        _lines(figure, view.t_s[1:], view.rate_of_quat_deg_s.T, "xyz")
    return _axes(figure, "rate / (deg/s)")


def _rate_note(view: View) -> str:
    if view.sensors is not None:
        return "As measured along the body's axes, bias included."
    return "Of the attitude itself, body axes: raw samples were not recorded."


def _bias_section(view: View) -> str:
    if not len(view.bias_t_s):
        return ""
    figure = go.Figure()
    _lines(figure, view.bias_t_s, view.bias_deg_s.T, "xyz")
    note = parts.note("Of the gyroscope, as learnt at rest; body axes.")
    return parts.section("Bias", parts.plot(_axes(figure, "bias / (deg/s)", 300)), note)


def _acceleration_section(view: View) -> str:
    if view.sensors is None:
        return ""
    figure = go.Figure()
    _lines(figure, view.sensors.t_s, view.sensors.acc_b_g.T, "xyz")
    length = np.linalg.norm(view.sensors.acc_b_g, axis=1)
    _lines(figure, view.sensors.t_s, [length], ["length"], color=INK, width=1.0)
    note = parts.note("At rest the length is 1 g, or the accelerometer wants calibrating.")
    return parts.section("Acceleration", parts.plot(_axes(figure, "acceleration / g")), note)


def _field_section(view: View) -> str:
    if view.sensors is None or view.sensors.mag_b_ut is None:
        return ""
    figure = go.Figure()
    field = view.sensors.mag_b_ut
    _lines(figure, view.sensors.t_s, field.T, "xyz")
    _lines(
        figure,
        view.sensors.t_s,
        [np.linalg.norm(field, axis=1)],
        ["length"],
        color=INK,
        width=1.0,
    )
    note = parts.note(
        "The earth's field is 25 to 65 uT and has one length wherever the board looks; a length "
        "that changes as it turns wants calibrating (terazi calibrate --mag)."
    )
    return parts.section("Magnetometer", parts.plot(_axes(figure, "field / uT")), note)


def _error_section(view: View) -> str:
    if not view.error_deg:
        return ""
    figure = go.Figure()
    _lines(figure, view.t_s, view.error_deg.values(), view.error_deg)
    words = "Against the recording's truth."
    if view.heading_is_free:
        words += " Six axes know no north: a constant heading is taken off."
    plot = parts.plot(_axes(figure, "error / deg", 320))
    return parts.section("Error", plot, parts.note(words))
