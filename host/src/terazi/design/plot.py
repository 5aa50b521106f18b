# SPDX-License-Identifier: MIT
"""Responses of designs as a figure: SVG by hand, for pages, or plotly's HTML, to look into."""

from __future__ import annotations

import html
from dataclasses import dataclass

import numpy as np

from terazi.design import fir

WIDTH, HEIGHT, MARGIN = 720, 360, 48
FLOOR_DB = -90.0
COLOURS = ("#0b6e99", "#b3541e", "#4c7a34", "#7a3b8f", "#8a6d1b", "#5b6770", "#a1356b")
FREQUENCIES = 401  # from 0 to half the rate
LINE_PITCH = 18
END, MIDDLE = 'text-anchor="end"', 'text-anchor="middle"'


@dataclass(frozen=True)
class Curve:
    """One design's response at a rate, and the limit that it is held to, if there is one."""

    name: str
    taps_q15: np.ndarray
    rate_hz: float
    stop_from_hz: float
    stop_max_db: float | None = None
    marks: tuple[tuple[float, str], ...] = ()  # (frequency after folding, words), as notches

    def points(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        frequencies = np.linspace(0, self.rate_hz / 2, count)
        return frequencies, fir.magnitude_db(self.taps_q15, frequencies, self.rate_hz)

    @property
    def words(self) -> str:
        return self.name if self.stop_max_db is None else f"{self.name}, dashed: its limit"


def _place(frequency_hz: float, level_db: float, rate_hz: float) -> str:
    x = MARGIN + frequency_hz / (rate_hz / 2) * (WIDTH - 2 * MARGIN)
    y = MARGIN + min(1.0, max(0.0, level_db / FLOOR_DB)) * (HEIGHT - 2 * MARGIN)
    return f"{x:.1f},{y:.1f}"


def _line(points: list[str], style: str) -> str:
    return f'<polyline points="{" ".join(points)}" fill="none" {style}/>'


def _text(place: str, words: str, style: str = "") -> str:
    x, y = place.split(",")
    return f'<text x="{x}" y="{y}" {style}>{html.escape(words)}</text>'


def _axes(rate_hz: float) -> list[str]:
    lines = []
    for level_db in range(0, int(FLOOR_DB) - 1, -30):
        ends = [_place(0, level_db, rate_hz), _place(rate_hz / 2, level_db, rate_hz)]
        lines.append(_line(ends, 'stroke="#ddd"'))
        x, y = ends[0].split(",")
        lines.append(_text(f"{float(x) - 8:.1f},{float(y) + 4:.1f}", f"{level_db} dB", END))
    for frequency_hz in _ticks(rate_hz / 2):
        x, y = _place(frequency_hz, FLOOR_DB, rate_hz).split(",")
        lines.append(_text(f"{x},{float(y) + 18:.1f}", f"{frequency_hz:g} Hz", MIDDLE))
    return lines


def _ticks(most_hz: float) -> list[float]:
    """Whole steps of 1, 2 or 5 by a power of ten, four to nine of them."""
    size = 10.0 ** np.floor(np.log10(most_hz / 4))
    step = next(size * each for each in (5, 2, 1) if most_hz / (size * each) >= 4)
    return [step * k for k in range(int(most_hz / step + 1e-9) + 1)]


def svg(curves: list[Curve], comments: tuple[str, ...] = ()) -> str:
    """One picture of all curves over the frequencies of the fastest of them."""
    rate_hz = max(curve.rate_hz for curve in curves)
    lines = _axes(rate_hz)
    for index, curve in enumerate(curves):
        colour = COLOURS[index % len(COLOURS)]
        pairs = zip(*(each.tolist() for each in curve.points(FREQUENCIES)), strict=True)
        lines.append(_line([_place(*pair, rate_hz) for pair in pairs], f'stroke="{colour}"'))
        if curve.stop_max_db is not None:
            band = (curve.stop_from_hz, curve.rate_hz / 2)
            limit = [_place(hz, curve.stop_max_db, rate_hz) for hz in band]
            lines.append(_line(limit, f'stroke="{colour}" stroke-dasharray="6 4"'))
        for frequency_hz, words in curve.marks:
            foot = [_place(frequency_hz, level, rate_hz) for level in (FLOOR_DB + 8, FLOOR_DB)]
            lines.append(_line(foot, f'stroke="{colour}"'))
            lines.append(_text(foot[0], words, f'{MIDDLE} fill="{colour}"'))
        where = f"{WIDTH - MARGIN},{MARGIN - 24 + LINE_PITCH * index}"
        lines.append(_text(where, curve.words, f'{END} fill="{colour}"'))
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        'font-family="sans-serif" font-size="12">'
    )
    background = f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>'
    told = [f"<!-- {comment} -->" for comment in comments]
    return "\n".join([*told, head, background, *lines, "</svg>", ""])


def page(curves: list[Curve], title: str) -> str:
    """An HTML page by plotly, everything in it."""
    import plotly.graph_objects as go

    figure = go.Figure()
    for index, curve in enumerate(curves):
        colour = COLOURS[index % len(COLOURS)]
        frequencies, levels = curve.points(8 * FREQUENCIES)
        line = {"color": colour}
        figure.add_scatter(x=frequencies, y=levels, name=curve.name, mode="lines", line=line)
        if curve.stop_max_db is not None:
            figure.add_scatter(
                x=[curve.stop_from_hz, curve.rate_hz / 2],
                y=[curve.stop_max_db] * 2,
                name=f"{curve.name}: limit",
                mode="lines",
                line={"color": colour, "dash": "dash"},
            )
        for frequency_hz, words in curve.marks:
            figure.add_vline(
                frequency_hz, line={"color": colour, "dash": "dot"}, annotation_text=words
            )
    figure.update_layout(title=title, template="plotly_white", hovermode="x unified")
    figure.update_xaxes(title_text="frequency after sampling / Hz", rangemode="tozero")
    figure.update_yaxes(title_text="gain / dB", range=[2 * FLOOR_DB / 1.5, 5])
    return figure.to_html(include_plotlyjs=True, include_mathjax=False, full_html=True)
