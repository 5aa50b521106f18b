# SPDX-License-Identifier: MIT
"""The page of a recording."""

import html
from datetime import datetime
from pathlib import Path

import numpy as np

from terazi import units
from terazi.control import faults
from terazi.link.generated.messages import Fault, Status, Step, WeightFlag
from terazi.link.plain import plain_message
from terazi.recorder.recording import Recording
from terazi.report import attitude, figures, parts
from terazi.report.analysis import BAND_SHARE, SETTLED_AFTER_S, STAGES, Analysis

ROWS_SHOWN = 24  # of steps and faults

# Health counters that say that something went wrong as soon as they leave zero.
FAULTS = (
    "converter_timeouts",
    "converter_bad_frames",
    "conversions_missed",
    "at_rail",
    "fir_clipped",
    "kf_clipped",
    "tx_frames_dropped",
    "rx_overruns",
    "rx_bad_frames",
)


def write_report(path: Path, recording: Recording, analysis: Analysis) -> None:
    """Write the page, whole or not at all. Raises CannotWrite."""
    parts.write_page(path, render(recording, analysis))


def render(recording: Recording, analysis: Analysis) -> str:
    """The page's text."""
    return parts.page_of(
        f"Terazi: {recording.path.name}",
        [
            _heading(recording, analysis),
            _cards(recording, analysis),
            parts.section(
                "Weight over time",
                parts.plot(figures.weight_over_time(analysis)),
                _time_note(analysis),
            ),
            _steps_section(analysis),
            parts.section("Noise of each stage", _noise_table(analysis), _noise_note(analysis)),
            _spectrum_section(analysis),
            _timing_section(recording, analysis),
            _scale_section(recording),
            attitude.section(recording),
            parts.section("Health of the board", _health_table(recording)),
            parts.footer(),
        ],
    )


def _heading(recording: Recording, analysis: Analysis) -> str:
    hello = recording.hello
    version = f"{hello.version_major}.{hello.version_minor}.{hello.version_patch}"
    build = f" (build {hello.build:08x})" if hello.build else ""
    metadata = recording.metadata
    facts = [
        _when(metadata.get("started", "")),
        f"firmware {version}{build}",
        f"port {html.escape(str(metadata.get('port', 'unknown')))}",
        f"protocol 0x{hello.protocol_fingerprint:04X}",
    ]
    lines = [
        "<header>",
        f"<h1>{html.escape(recording.path.name)}</h1>",
        f'<p class="facts">{" · ".join(fact for fact in facts if fact)}</p>',
    ]
    if not recording.ended_cleanly:
        lines.append(
            '<p class="warning">This recording was cut off; everything up to the cut is shown.</p>'
        )
    return "\n".join([*lines, "</header>"])


def _when(started: str) -> str:
    try:
        return f"{datetime.fromisoformat(started):%Y-%m-%d %H:%M:%S} UTC"
    except ValueError:
        return ""


def _cards(recording: Recording, analysis: Analysis) -> str:
    quieter = analysis.noise_rms_g["raw"] / analysis.noise_rms_g["kalman"]
    settled = [step.settling_s["kalman"] for step in analysis.steps]
    known = [time_s for time_s in settled if time_s is not None]
    cards = [
        (f"{len(recording):,}".replace(",", " "), "samples", False),
        (units.show_duration(float(analysis.t_s[-1])), "recorded", False),
        (f"{analysis.rate_hz:.3f} SPS", "measured rate", False),
        (str(recording.frames_lost), "frames lost", recording.frames_lost > 0),
        (str(recording.frames_bad), "frames corrupt", recording.frames_bad > 0),
    ]
    if np.isfinite(analysis.noise_rms_g["kalman"]):
        cards.append((_gram(analysis.noise_rms_g["kalman"]), "Kalman noise rms", False))
    if np.isfinite(quieter):
        cards.append((f"{quieter:.1f}×", "quieter than raw", False))
    if known:
        cards.append((f"{max(known):.2f} s", "Kalman settles within", False))
    boxes = [
        f'<div class="card{" bad" if bad else ""}"><b>{value}</b><span>{label}</span></div>'
        for value, label, bad in cards
    ]
    return '<div class="cards">' + "".join(boxes) + "</div>"


def _gram(value_g: float) -> str:
    """A small weight with three significant digits, in a fitting unit."""
    if not np.isfinite(value_g):
        return "–"
    if abs(value_g) < 1.0:
        return f"{value_g * 1000:.3g} mg"
    return f"{value_g:.3g} g" if abs(value_g) < 1000 else f"{value_g:.0f} g"


def _time_note(analysis: Analysis) -> str:
    words = ["Drag to zoom, double-click to see all, click a name to hide it."]
    if len(analysis.t_s) > figures.POINTS_SHOWN:
        words.append("Drawn from the extremes of short stretches; the tables hold every sample.")
    if analysis.truth_g is not None:
        words.append(
            "The truth's clock was fitted to the signal: shifted by "
            f"{analysis.truth_shift_s:.3f} s."
        )
    return parts.note(" ".join(words))


def _steps_section(analysis: Analysis) -> str:
    if not analysis.steps:
        return parts.section("Changes of load", parts.note("None was found in this recording."))
    rows = [
        [
            f"{step.t_s:.2f} s",
            f"{figures.level(step.from_g, 1)} → {figures.level(step.to_g, 1)}",
            *(_settling(step.settling_s[stage]) for stage in STAGES),
        ]
        for step in analysis.steps
    ]
    head = ["at", "load", *(f"{figures.NAMES[stage]} settles in" for stage in STAGES)]
    note = parts.note(
        "Settling: from the step until a stage stays within "
        f"{BAND_SHARE * 100:g} % of the step (the grey band) around the level at which it ends "
        "up. “Never”: its noise is wider than that band."
    )
    zooms = parts.plot(figures.step_zooms(analysis))
    return parts.section("Changes of load", parts.table(head, rows), note, zooms)


def _settling(time_s: float | None) -> str:
    return '<span class="never">never</span>' if time_s is None else f"{time_s:.3f} s"


def _noise_table(analysis: Analysis) -> str:
    if not analysis.plateaus:
        return parts.note("No stretch of the recording is long enough to speak of noise.")
    head = ["stage", "rms", "peak to peak", "against raw"]
    if analysis.truth_error_g:
        head.append("error to the truth, rms")
    rows = []
    for stage in STAGES:
        rms_g = analysis.noise_rms_g[stage]
        share = analysis.noise_rms_g["raw"] / rms_g if rms_g else float("inf")
        row = [
            f'<i style="background:{figures.COLOURS[stage]}"></i>{figures.NAMES[stage]}',
            _gram(rms_g),
            _gram(analysis.noise_p2p_g[stage]),
            "–" if stage == "raw" else f"{share:.1f}× quieter",
        ]
        if analysis.truth_error_g:
            row.append(_gram(analysis.truth_error_g[stage]))
        rows.append(row)
    return parts.table(head, rows)


def _noise_note(analysis: Analysis) -> str:
    return parts.note(
        f"Over the settled stretches ({len(analysis.plateaus)} here), each from "
        f"{SETTLED_AFTER_S:g} s after a change of load to the next; about a straight line, so that "
        "creep is not counted as noise."
    )


def _spectrum_section(analysis: Analysis) -> str:
    figure = figures.spectrum(analysis)
    if figure is None:
        return ""
    note = parts.note(
        "Of the settled stretches. What shakes the scale stands out as peaks; above half the rate "
        "it is folded back: mains hum of 50 Hz appears at "
        f"{abs(50 - analysis.rate_hz * round(50 / analysis.rate_hz)):.1f} Hz."
    )
    return parts.section("Spectrum", parts.plot(figure), note)


def _timing_section(recording: Recording, analysis: Analysis) -> str:
    known = analysis.interval_ms[np.isfinite(analysis.interval_ms)]
    if not len(known):
        return ""
    first_us = int(recording.samples["device_us"][0])
    statuses = [
        (
            units.s_from_us(one.device_us - first_us),
            units.hz_from_q16(one.message.converter_rate_hz_q16),
        )
        for _at, one in recording.of_kind(Status)
        if one.message.converter_rate_hz_q16 and one.boot == 0
    ]
    figure = figures.timing(analysis, statuses)
    rows = [
        ["rate", f"{analysis.rate_hz:.4f} SPS"],
        ["median interval", f"{np.median(known):.4f} ms"],
        ["spread of intervals, rms", f"{np.std(known) * 1000:.2f} µs"],
        ["shortest, longest", f"{known.min():.4f} ms, {known.max():.4f} ms"],
    ]
    return parts.section(
        "Timing", parts.table(["by the device's stamps", ""], rows), parts.plot(figure)
    )


def _scale_section(recording: Recording) -> str:
    """Stability, zero, steps and faults, as the device told them."""
    flags = recording.samples["weight_flags"]
    stable = float(np.mean(flags & int(WeightFlag.STABLE) != 0))
    rows = [
        ["marked stable", f"{stable:.1%} of the samples"],
        ["tare", "taken off" if flags[-1] & int(WeightFlag.TARED) else "none"],
    ]
    first_us = int(recording.samples["device_us"][0])
    for _at, one in recording.of_kind(Step):
        at_s = units.s_from_us(one.device_us - first_us)
        step_g = [
            units.show_g(units.g_from_mg(mg)) for mg in (one.message.from_mg, one.message.to_mg)
        ]
        rows.append([f"step at {at_s:.3f} s", " → ".join(step_g)])
    for _at, one in recording.of_kind(Fault):
        at_s = units.s_from_us(one.device_us - first_us)
        come = faults.names(one.message.faults & one.message.changed)
        gone = faults.names(~one.message.faults & one.message.changed)
        words = [f'<span class="never">{name}</span>' for name in come]
        rows.append(
            [f"fault at {at_s:.3f} s", ", ".join([*words, *(f"{name} over" for name in gone)])]
        )
    shown, left = rows[:ROWS_SHOWN], len(rows) - ROWS_SHOWN
    if left > 0:
        shown.append([f"and {left} more", "in the table of events beside the capture"])
    return parts.section("What the scale told", parts.table(["as the device saw it", ""], shown))


def _health_table(recording: Recording) -> str:
    status = recording.last_status
    if status is None:
        return parts.note("The recording holds no STATUS.")
    rows = []
    for name, value in plain_message(status).items():
        is_bad = name in FAULTS and value
        if name in ("faults", "faults_seen"):
            is_bad, value = bool(value), ", ".join(faults.names(value)) or "none"
        text = html.escape(str(value))
        rows.append(
            [name.replace("_", " "), f'<span class="never">{text}</span>' if is_bad else text]
        )
    rows += [
        ["frames lost on the way (this host's count)", str(recording.frames_lost)],
        ["frames refused by their check (this host's count)", str(recording.frames_bad)],
    ]
    return parts.table(["at the end of the recording", ""], rows)
