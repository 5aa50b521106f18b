# SPDX-License-Identifier: MIT
"""A page of plots of one walk: plan, height, velocity, motion against its threshold, and below all
over time the bars of zero velocity. Plotly, as the reports of weighing have it."""

from __future__ import annotations

import html
from pathlib import Path

import numpy as np

from terazi.applications.walks.estimate import Result
from terazi.applications.walks.score import aligned
from terazi.applications.walks.steps import stances
from terazi.applications.walks.summary import summarise
from terazi.errors import CannotWrite, UsageError

PATH, TRUTH, MOTION, BAR = "#3d8fe0", "#12a37a", "#e69f00", "rgba(125,133,144,0.28)"
INK, GRID = "#7d8590", "rgba(125,133,144,0.22)"
POINTS_SHOWN = 8000
BARS_SHOWN = 1500
LEGEND_UP_PX = 18  # clear of a title in the middle

STYLE = (
    "body{font-family:system-ui,sans-serif;margin:2rem auto;max-width:70rem;padding:0 1rem;"
    "color-scheme:light dark}table{border-collapse:collapse}td{padding:.15rem 1.2rem .15rem 0}"
    ".note{color:#b26a00}"
)


def write_page(target: Path, result: Result) -> None:
    """Replace what is there. UsageError where plotly is missing."""
    try:
        import plotly.graph_objects as go
        from plotly.subplots import make_subplots
    except ImportError:
        raise UsageError(
            "plots need plotly", remedy="Install it: pip install 'terazi[report]'"
        ) from None
    body = [_plan(go, result), _times(go, make_subplots, result)]
    divs = [
        figure.to_html(full_html=False, include_plotlyjs="inline" if at == 0 else False)
        for at, figure in enumerate(body)
    ]
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td>{html.escape(value)}</td></tr>"
        for name, value in summarise(result).rows()
    )
    notes = "".join(f'<p class="note">{html.escape(each)}</p>' for each in result.walk.notes)
    name = html.escape(result.walk.name)
    text = (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{name}</title>'
        f"<style>{STYLE}</style><h1>{name}</h1><table>{rows}</table>{notes}{''.join(divs)}</html>"
    )
    try:
        target.write_text(text, encoding="utf-8")
    except OSError as error:
        raise CannotWrite(f"{target}: {error.strerror or error}") from None


def _plan(go, result: Result):
    """From above; with the truth turned to the path where there is one."""
    pos = result.path.pos_w_m
    figure = go.Figure()
    shown = _shown(len(pos))
    figure.add_trace(_line(go, pos[shown, 0], pos[shown, 1], "path", PATH))
    steps = result.strides.pos_w_m
    figure.add_trace(
        go.Scatter(
            x=np.round(steps[:, 0], 4),
            y=np.round(steps[:, 1], 4),
            mode="markers",
            name="stances",
            marker={"color": PATH, "size": 5},
        )
    )
    truth = result.walk.truth
    if truth is not None:
        points = _truth_in_path(pos, truth)
        shown = _shown(len(points))
        figure.add_trace(_line(go, points[shown, 0], points[shown, 1], "truth", TRUTH))
    _style(figure, 520)
    figure.update_xaxes(title_text="x / m")
    figure.update_yaxes(title_text="y / m", scaleanchor="x", scaleratio=1)
    return figure


def _truth_in_path(pos: np.ndarray, truth) -> np.ndarray:
    """The truth's points in the path's axes: the turn of `aligned`, taken back."""
    ours, theirs = aligned(pos, truth)
    raw = pos[truth.at][:, : ours.shape[1]]
    if len(raw) < 2:
        return raw
    centre, base = ours.mean(axis=0), raw.mean(axis=0)
    level = (raw - base)[:, 0] + 1j * (raw - base)[:, 1]
    turned = (ours - centre)[:, 0] + 1j * (ours - centre)[:, 1]
    back = np.exp(1j * np.angle(np.sum(level * turned.conj())))
    plan = ((theirs - centre)[:, 0] + 1j * (theirs - centre)[:, 1]) * back
    return np.column_stack([plan.real, plan.imag, (theirs - centre)[:, 2:]]) + base


def _times(go, make_subplots, result: Result):
    walk, path, detection = result.walk, result.path, result.detection
    figure = make_subplots(
        3,
        1,
        shared_xaxes=True,
        vertical_spacing=0.06,
        subplot_titles=["height / m", "velocity / (m/s)", f"motion / ({detection.unit})"],
    )
    shown = _shown(len(walk))
    t_s = walk.t_s[shown]
    speed = np.linalg.norm(path.vel_w_m_s, axis=1)
    figure.add_trace(_line(go, t_s, path.pos_w_m[shown, 2], "height", PATH), row=1, col=1)
    if walk.truth is not None and walk.truth.pos_t_m.shape[1] == 3:
        height = _truth_in_path(path.pos_w_m, walk.truth)[:, 2]
        some = _shown(len(height))
        times = walk.t_s[walk.truth.at][some]
        figure.add_trace(_line(go, times, height[some], "true height", TRUTH), row=1, col=1)
    figure.add_trace(_line(go, t_s, speed[shown], "speed", PATH), row=2, col=1)
    figure.add_trace(_line(go, t_s, detection.motion[shown], "motion", MOTION), row=3, col=1)
    figure.add_trace(_line(go, t_s, detection.threshold[shown], "threshold", INK), row=3, col=1)
    figure.update_yaxes(type="log", row=3, col=1)
    bars = []
    for begin, end in stances(path.still, walk.rate_hz)[:BARS_SHOWN]:
        box = {"x0": float(walk.t_s[begin]), "x1": float(walk.t_s[end - 1]), "y0": 0, "y1": 1}
        bars.append({**box, "type": "rect", "xref": "x", "yref": "paper", "layer": "below",
                     "line": {"width": 0}, "fillcolor": BAR})  # fmt: skip
    _style(figure, 820)
    figure.update_layout(shapes=bars)
    figure.update_xaxes(title_text="time / s; grey: zero velocity", row=3, col=1)
    return figure


def _shown(count: int) -> np.ndarray:
    return np.unique(np.linspace(0, count - 1, min(count, POINTS_SHOWN)).astype(np.int64))


def _line(go, x, y, name: str, colour: str):
    return go.Scatter(
        x=np.round(x, 4), y=np.round(y, 4), mode="lines", name=name, line={"color": colour}
    )


def _style(figure, height: int) -> None:
    figure.update_layout(
        template="none",
        height=height,
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        font={"family": "system-ui, sans-serif", "size": 13, "color": INK},
        margin={"l": 70, "r": 20, "t": 50, "b": 55},
        legend={"orientation": "h", "x": 0, "y": 1.04 + LEGEND_UP_PX / height},
    )
    figure.update_xaxes(gridcolor=GRID, zeroline=False)
    figure.update_yaxes(gridcolor=GRID, zeroline=False)
