# SPDX-License-Identifier: MIT
"""The plots of a report, as plotly figures that stand on light and dark grounds alike."""

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from terazi.report.analysis import BAND_SHARE, RATE_WINDOW_S, STAGES, Analysis, rate_over_time

# Told apart by everybody, on white and on near-black (after Okabe and Ito 2008).
COLOURS = {"raw": "#9aa3ad", "fir": "#e69f00", "kalman": "#3d8fe0", "truth": "#12a37a"}
NAMES = {"raw": "raw", "fir": "FIR", "kalman": "Kalman", "truth": "truth"}
INK = "#7d8590"
GRID = "rgba(125,133,144,0.22)"

POINTS_SHOWN = 6000  # a trace; beyond that, the extremes of each bin are drawn
ZOOMS_SHOWN = 6
ZOOM_BEFORE_S, ZOOM_AFTER_S = 0.4, 1.8


def weight_over_time(analysis: Analysis) -> go.Figure:
    """All stages over the whole recording."""
    figure = go.Figure()
    for stage in STAGES:
        t_s, values_g = thinned(analysis.t_s, analysis.stages_g[stage])
        figure.add_trace(_line(t_s, values_g, stage))
    _add_truth(figure, analysis, 0, len(analysis.t_s))
    style(figure, height=430)
    figure.update_xaxes(title_text="device time since the first sample / s")
    figure.update_yaxes(title_text="weight / g")
    return figure


def step_zooms(analysis: Analysis) -> go.Figure | None:
    """Each change of load from close by; None if there is none."""
    steps = analysis.steps[:ZOOMS_SHOWN]
    if not steps:
        return None
    columns = min(2, len(steps))
    rows = -(-len(steps) // columns)
    titles = [f"{level(step.from_g)} → {level(step.to_g)} at {step.t_s:.2f} s" for step in steps]
    figure = make_subplots(
        rows,
        columns,
        subplot_titles=titles,
        vertical_spacing=0.28 / rows,
        horizontal_spacing=0.09,
    )
    for number, step in enumerate(steps):
        place = {"row": number // columns + 1, "col": number % columns + 1}
        begin, end = np.searchsorted(
            analysis.t_s, [step.t_s - ZOOM_BEFORE_S, step.t_s + ZOOM_AFTER_S]
        )
        band_g = BAND_SHARE * abs(step.size_g)
        figure.add_hrect(
            step.to_g - band_g,
            step.to_g + band_g,
            line_width=0,
            fillcolor=GRID,
            layer="below",
            **place,
        )
        for stage in STAGES:
            trace = _line(
                analysis.t_s[begin:end] - step.t_s, analysis.stages_g[stage][begin:end], stage
            )
            figure.add_trace(trace.update(showlegend=number == 0, legendgroup=stage), **place)
        _add_truth(figure, analysis, begin, end, origin_s=step.t_s, first=number == 0, **place)
    style(figure, height=90 + 300 * rows)
    figure.update_xaxes(title_text="time since the step / s", row=rows)
    figure.update_yaxes(title_text="weight / g", col=1)
    figure.update_annotations(font_size=13)
    return figure


def spectrum(analysis: Analysis) -> go.Figure | None:
    """Noise by frequency, each stage; None if no plateau is long enough."""
    if not len(analysis.spectrum_hz):
        return None
    figure = go.Figure()
    for stage in STAGES:
        figure.add_trace(_line(analysis.spectrum_hz, analysis.spectrum_g_rthz[stage], stage))
    style(figure, height=380)
    figure.update_xaxes(title_text="frequency / Hz", range=[0, analysis.rate_hz / 2])
    figure.update_yaxes(
        title_text="amplitude density / (g/√Hz)", type="log", exponentformat="power"
    )
    return figure


def timing(analysis: Analysis, statuses: list[tuple[float, float]]) -> go.Figure | None:
    """The converter's rate over time, and how the intervals spread; None without intervals."""
    known = analysis.interval_ms[np.isfinite(analysis.interval_ms)]
    if not len(known):
        return None
    figure = make_subplots(
        1,
        2,
        column_widths=[0.62, 0.38],
        horizontal_spacing=0.1,
        subplot_titles=["conversion rate", "intervals between conversions"],
    )
    t_s, rate_hz = rate_over_time(analysis.t_s, analysis.interval_ms)
    figure.add_trace(
        go.Scatter(
            x=t_s,
            y=rate_hz,
            mode="lines",
            name=f"from stamps, {RATE_WINDOW_S:g} s windows",
            line={"color": COLOURS["kalman"], "width": 1.6},
        ),
        row=1,
        col=1,
    )
    if statuses:
        figure.add_trace(
            go.Scatter(
                x=[t for t, _rate in statuses],
                y=[rate for _t, rate in statuses],
                mode="markers",
                name="as the device measured it",
                marker={"color": COLOURS["fir"], "size": 5},
            ),
            row=1,
            col=1,
        )
    figure.add_trace(
        go.Histogram(
            x=known,
            nbinsx=60,
            showlegend=False,
            marker={"color": COLOURS["kalman"]},
            hovertemplate="%{x} ms: %{y}<extra></extra>",
        ),
        row=1,
        col=2,
    )
    style(figure, height=340)
    figure.update_layout(bargap=0.02)
    figure.update_xaxes(title_text="device time / s", row=1, col=1)
    figure.update_yaxes(title_text="rate / SPS", tickformat=".3f", row=1, col=1)
    figure.update_xaxes(title_text="interval / ms", row=1, col=2)
    figure.update_yaxes(title_text="conversions", row=1, col=2)
    # A quiet clock would otherwise fill the plot with its last digits.
    middle = float(np.median(rate_hz)) if len(rate_hz) else analysis.rate_hz
    swing = max(np.abs(rate_hz - middle).max(initial=0.0) * 1.2, 0.002 * middle)
    figure.update_yaxes(range=[middle - swing, middle + swing], row=1, col=1)
    return figure


def level(weight_g: float, digits: int = 0) -> str:
    """A load in gram; what rounds to nothing has no sign."""
    return f"{round(weight_g, digits) + 0.0:,.{digits}f} g".replace(",", " ")


def thinned(t_s: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """At most POINTS_SHOWN points: of each bin the lowest and the highest, in their order."""
    if len(values) <= POINTS_SHOWN:
        return t_s, values
    bins = POINTS_SHOWN // 2
    width = -(-len(values) // bins)
    starts = np.arange(0, len(values), width)
    low = np.array([at + np.argmin(values[at : at + width]) for at in starts])
    high = np.array([at + np.argmax(values[at : at + width]) for at in starts])
    kept = np.unique(np.concatenate([low, high]))
    return t_s[kept], values[kept]


def _line(x: np.ndarray, y: np.ndarray, stage: str) -> go.Scatter:
    width = 1.0 if stage == "raw" else 2.0
    return go.Scatter(
        x=np.round(x, 5),
        y=_rounded(y),
        mode="lines",
        name=NAMES[stage],
        line={"color": COLOURS[stage], "width": width},
    )


def _rounded(values: np.ndarray) -> np.ndarray:
    """Five significant digits of the range are more than a screen shows; the file stays small."""
    spread = float(np.nanmax(np.abs(values), initial=1e-9))
    return np.round(values, int(np.clip(7 - np.ceil(np.log10(spread)), 0, 9)))


def _add_truth(figure, analysis, begin, end, *, origin_s=0.0, first=True, **place) -> None:
    """The truth as steps: only where it changes, so that its corners are sharp."""
    if analysis.truth_g is None:
        return
    t_s, truth_g = analysis.t_s[begin:end], analysis.truth_g[begin:end]
    if not np.isfinite(truth_g).any():
        return
    keep = np.ones(len(truth_g), bool)
    keep[1:-1] = (truth_g[1:-1] != truth_g[:-2]) | (truth_g[1:-1] != truth_g[2:])
    trace = _line(t_s[keep] - origin_s, truth_g[keep], "truth")
    trace.update(
        line={"dash": "dash", "width": 1.6, "shape": "hv"}, showlegend=first, legendgroup="truth"
    )
    figure.add_trace(trace, **place)


def style(figure: go.Figure, *, height: int) -> None:
    """As all figures look."""
    figure.update_layout(
        template="none",
        height=height,
        margin={"l": 70, "r": 20, "t": 50, "b": 55},
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        font={"family": "system-ui, sans-serif", "size": 13, "color": INK},
        legend={"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom", "xanchor": "left"},
        modebar={"bgcolor": "rgba(0,0,0,0)", "color": INK, "activecolor": COLOURS["kalman"]},
        hovermode="x unified",
        hoverlabel={"bgcolor": "#20242a", "font": {"color": "#f0f2f4"}},
    )
    if height > 430 or figure.layout.annotations:  # subplot titles stand where a legend would
        figure.update_layout(
            legend={"y": 1.0 + 34 / (height - 105), "yanchor": "bottom"}, margin={"t": 84}
        )
    axis = {
        "gridcolor": GRID,
        "linecolor": INK,
        "zeroline": False,
        "ticks": "outside",
        "tickcolor": GRID,
        "showline": True,
        "title": {"font": {"size": 13}, "standoff": 10},
        "tickfont": {"size": 12},
    }
    figure.update_xaxes(**axis)
    figure.update_yaxes(**axis, automargin=True)
