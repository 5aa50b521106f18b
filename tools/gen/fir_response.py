# SPDX-License-Identifier: MIT
"""Renders fir_response.svg: what the quantised designs of fir.toml do, beside their limits."""

from __future__ import annotations

import numpy as np

from terazi.design import fir, specs
from tools.gen.spec import Spec

WIDTH, HEIGHT, MARGIN = 720, 360, 48
FLOOR_DB = -90.0
COLOURS = ("#0b6e99", "#b3541e", "#4c7a34", "#7a3b8f", "#8a6d1b")
FREQUENCIES = 401  # from 0 to half the rate


def _place(frequency_hz: float, level_db: float, rate_hz: float) -> str:
    x = MARGIN + frequency_hz / (rate_hz / 2) * (WIDTH - 2 * MARGIN)
    y = MARGIN + min(1.0, max(0.0, level_db / FLOOR_DB)) * (HEIGHT - 2 * MARGIN)
    return f"{x:.1f},{y:.1f}"


def _line(points: list[str], style: str) -> str:
    return f'<polyline points="{" ".join(points)}" fill="none" {style}/>'


def _text(place: str, words: str, style: str = "") -> str:
    x, y = place.split(",")
    return f'<text x="{x}" y="{y}" {style}>{words}</text>'


def _axes(rate_hz: float) -> list[str]:
    lines = []
    for level_db in range(0, int(FLOOR_DB) - 1, -30):
        ends = [_place(0, level_db, rate_hz), _place(rate_hz / 2, level_db, rate_hz)]
        lines.append(_line(ends, 'stroke="#ddd"'))
        x, y = ends[0].split(",")
        lines.append(_text(f"{float(x) - 8:.1f},{float(y) + 4:.1f}", f"{level_db} dB", END))
    for frequency_hz in range(0, int(rate_hz / 2) + 1, 10):
        x, y = _place(frequency_hz, FLOOR_DB, rate_hz).split(",")
        lines.append(_text(f"{x},{float(y) + 18:.1f}", f"{frequency_hz} Hz", MIDDLE))
    return lines


END, MIDDLE = 'text-anchor="end"', 'text-anchor="middle"'


def page(spec: Spec) -> str:
    """Text of fir_response.svg."""
    designs = spec.content["design"]
    lines = _axes(designs[0]["nominal_rate_hz"])
    for index, design in enumerate(designs):
        rate_hz, colour = design["nominal_rate_hz"], COLOURS[index % len(COLOURS)]
        frequencies = np.linspace(0, rate_hz / 2, FREQUENCIES)
        levels = fir.magnitude_db(specs.fir_taps_q15(design["name"]), frequencies, rate_hz)
        pairs = zip(frequencies.tolist(), levels.tolist(), strict=True)
        lines.append(_line([_place(*pair, rate_hz) for pair in pairs], f'stroke="{colour}"'))
        start_hz, limit_db = design["stopband_from_hz"], design["stopband_max_db"]
        limit = [_place(hz, limit_db, rate_hz) for hz in (start_hz, rate_hz / 2)]
        lines.append(_line(limit, f'stroke="{colour}" stroke-dasharray="6 4"'))
        words = f"{design['name']}, dashed: its limit"
        where = f"{WIDTH - MARGIN},{MARGIN - 24 + 18 * index}"
        lines.append(_text(where, words, f'{END} fill="{colour}"'))
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        'font-family="sans-serif" font-size="12">'
    )
    background = f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>'
    licence = "<!-- SPDX-License-Identifier: MIT -->"
    return "\n".join([f"<!-- {spec.origin} -->", licence, head, background, *lines, "</svg>", ""])
