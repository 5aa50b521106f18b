# SPDX-License-Identifier: MIT
"""The page of `terazi weigh dynamic`: what the belt is like, and who weighs it how well."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from terazi.report import figures, parts

if TYPE_CHECKING:
    from terazi.applications.weighing.belt import Passage, Record
    from terazi.applications.weighing.dynamic import Dynamic, Samples

SHOWN = 4  # products from close by, one of each part of the tones
OURS = "checkweigher"


def write_belt_page(path: Path, record: Record, samples: Samples, result: Dynamic) -> None:
    """Write the page, whole or not at all. Raises CannotWrite."""
    parts.write_page(path, render(record, samples, result))


def render(record: Record, samples: Samples, result: Dynamic) -> str:
    """The page's text."""
    return parts.page_of(
        "Terazi: products on a belt",
        [
            "<header><h1>Products on a simulated belt</h1>"
            f'<p class="facts">{len(result.passages)} products · '
            f"{result.throughput_per_min:.1f} a minute · weighed by the {result.weighed_by} · "
            f"seed {record.belt.seed}</p></header>",
            parts.section(
                "Some products",
                parts.plot(_products(samples, result)),
                parts.note(
                    "Converter samples less the true weight, while each product rolls on, lies on "
                    "the platform and rolls off; one of each part of the tones."
                ),
            ),
            parts.section("Error of each product", parts.plot(_errors(result))),
            parts.section(
                "Beside common filters",
                parts.plot(_sigmas(result)),
                _table(result),
                parts.note(
                    "Each filter sees all samples of the time wholly on the platform, and has the "
                    "one setting, of many, that spread least over other products of the whole "
                    "range: "
                    + "; ".join(f"{name} {words}" for name, words in result.settings.items())
                    + ". No unbiased estimator can spread less than the converter's noise over the "
                    "root of the number of samples, 0.019 e; a window of a length that fits stiff "
                    "platforms alone comes near that from 10 Hz on."
                ),
            ),
            parts.footer(),
        ],
    )


def _chosen(result: Dynamic) -> list[Passage]:
    """The middle one of each quarter, by tone."""
    by_tone = sorted(result.passages, key=lambda passage: passage.tone_hz)
    return [by_tone[(2 * n + 1) * len(by_tone) // (2 * SHOWN)] for n in range(SHOWN)]


def _products(samples: Samples, result: Dynamic) -> go.Figure:
    chosen = _chosen(result)
    titles = [f"{each.weight_g:.0f} g at {each.tone_hz:.1f} Hz" for each in chosen]
    figure = make_subplots(2, 2, subplot_titles=titles, vertical_spacing=0.16)
    for number, passage in enumerate(chosen):
        begin, end = np.searchsorted(
            samples.time_s, [passage.enters_s - 0.02, passage.leaves_s + 0.02]
        )
        trace = go.Scatter(
            x=samples.time_s[begin:end] - passage.on_s,
            y=samples.mass_g[begin:end] - passage.weight_g,
            mode="lines+markers",
            line_color=figures.COLOURS["kalman"],
            showlegend=False,
        )
        place = {"row": number // 2 + 1, "col": number % 2 + 1}
        figure.add_trace(trace, **place)
        figure.add_vrect(
            0, passage.off_s - passage.on_s, line_width=0, fillcolor=figures.GRID, **place
        )
        on = (samples.time_s > passage.on_s) & (samples.time_s < passage.off_s)
        swing_g = 1.2 * np.abs(samples.mass_g[on] - passage.weight_g).max()
        figure.update_yaxes(range=[-swing_g, swing_g], **place)
    figures.style(figure, height=640)
    figure.update_xaxes(title_text="time since wholly on the platform / s", row=2)
    figure.update_yaxes(title_text="off the weight / g", col=1)
    return figure


def _errors(result: Dynamic) -> go.Figure:
    figure = go.Figure(
        go.Scatter(
            x=[passage.tone_hz for passage in result.passages],
            y=result.errors_e,
            mode="markers",
            marker_color=figures.COLOURS["kalman"],
            text=[f"{passage.weight_g:.1f} g" for passage in result.passages],
        )
    )
    figures.style(figure, height=380)
    figure.update_xaxes(title_text="tone of the loaded platform / Hz", type="log")
    figure.update_yaxes(title_text="error / e")
    return figure


def _sigmas(result: Dynamic) -> go.Figure:
    tones = list(result.per_tone)
    figure = go.Figure()
    ours = [result.per_tone[tone].sigma_e for tone in tones]
    figure.add_trace(go.Bar(name=OURS, x=tones, y=ours, marker_color=figures.COLOURS["kalman"]))
    for name in result.peers:
        sigmas = [result.peers_per_tone[tone][name].sigma_e for tone in tones]
        figure.add_trace(go.Bar(name=name, x=tones, y=sigmas))
    figures.style(figure, height=420)
    figure.update_yaxes(title_text="sigma / e", type="log")
    return figure


def _table(result: Dynamic) -> str:
    head = ["", "mean error", "sigma", *result.per_tone]
    rows = [
        [
            OURS,
            f"{result.mean_error_e:+.3f} e",
            f"{result.sigma_e:.3f} e",
            *(f"{part.sigma_e:.3f} e" for part in result.per_tone.values()),
        ]
    ]
    for name, part in result.peers.items():
        sigmas = (f"{each[name].sigma_e:.3f} e" for each in result.peers_per_tone.values())
        rows.append([name, f"{part.mean_error_e:+.3f} e", f"{part.sigma_e:.3f} e", *sigmas])
    return parts.table(head, rows)
