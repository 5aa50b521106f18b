# SPDX-License-Identifier: MIT
"""The page's section on attitude, where a recording has one: angles, stillness, bias, health."""

import html

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from terazi import rotation, units
from terazi.control import inertial as words
from terazi.link.generated.messages import AttitudeFlag, ImuStatus
from terazi.link.plain import plain_message
from terazi.recorder.inertial import Inertial, quats_of
from terazi.recorder.recording import Recording
from terazi.report import figures, parts
from terazi.report.analysis import time_s

# After Okabe and Ito 2008, as the weight's figures.
ANGLE_COLOURS = {"roll": "#e69f00", "pitch": "#3d8fe0", "yaw": "#12a37a"}
AXIS_COLOURS = {"x": "#e69f00", "y": "#3d8fe0", "z": "#12a37a"}
# As bars over time; those that alarm come below.
STATES = {
    AttitudeFlag.REST: "#3d8fe0",
    AttitudeFlag.STILL: "#12a37a",
    AttitudeFlag.HEADING: "#9aa3ad",
    AttitudeFlag.DISTURBED: "#d55e00",
    AttitudeFlag.GAP: "#d55e00",
    AttitudeFlag.RAILED: "#d55e00",
    AttitudeFlag.RESTARTED: "#d55e00",
}
RATE_OF_BAR_S = 0.05  # so short a bar is drawn so long: it must be seen


def section(recording: Recording) -> str:
    """HTML; "" where the recording holds no attitude."""
    inertial = recording.inertial
    attitude = inertial.attitude
    if not len(attitude["sample"]):
        return ""
    quats = quats_of(attitude)
    known = quats.any(axis=1)
    if not known.any():
        return parts.section("Attitude", parts.note("The IMU had none yet."))
    t_s = _time_s(recording)
    rows = _facts(t_s[known], quats[known], attitude["flags"][known], inertial)
    return parts.section(
        "Attitude",
        parts.plot(angles_over_time(recording)),
        parts.note(
            "Body to world, yaw then pitch then roll; yaw is anticlockwise from where it began, "
            "or from magnetic east where a magnetometer gives a heading. At a pitch of 90° roll "
            "and yaw are one. Bars show when the device said so."
        ),
        parts.table(["as the device told it", ""], rows),
        _health(inertial),
    )


def _time_s(recording: Recording) -> np.ndarray:
    """On the axis of the weight's figures, where there is weight."""
    attitude, samples = recording.inertial.attitude, recording.samples
    t_s = time_s(attitude)
    if not len(recording) or attitude["boot"][0] != samples["boot"][0]:
        return t_s
    return t_s + units.s_from_us(float(attitude["device_us"][0] - samples["device_us"][0]))


def _statuses(recording: Recording, t_s: np.ndarray) -> list[tuple[float, ImuStatus]]:
    """IMU_STATUS of the first run of the device, with their times."""
    attitude = recording.inertial.attitude
    return [
        (t_s[0] + units.s_from_us(one.device_us - int(attitude["device_us"][0])), one.message)
        for _order, one in recording.inertial.told
        if isinstance(one.message, ImuStatus) and one.boot == attitude["boot"][0]
    ]


def angles_over_time(recording: Recording) -> go.Figure:
    """Roll, pitch and yaw; below them what the device said, and the bias that it learnt."""
    attitude = recording.inertial.attitude
    quats, all_s = quats_of(attitude), _time_s(recording)
    known = quats.any(axis=1)
    t_s, quats, flags = all_s[known], quats[known], attitude["flags"][known]
    statuses = _statuses(recording, all_s)
    titles = ["angles", "what the device said of it", "gyroscope's bias, learnt at rest"]
    figure = make_subplots(
        3, 1, shared_xaxes=True, row_heights=[0.5, 0.22, 0.28], subplot_titles=titles
    )
    angles = rotation.euler_deg(quats)
    for at, (name, colour) in enumerate(ANGLE_COLOURS.items()):
        x, y = figures.thinned(t_s, angles[:, at])
        y = np.where(np.abs(np.diff(y, prepend=y[:1])) > 180.0, np.nan, y)  # no line at a wrap
        line = {"color": colour, "width": 1.6}
        trace = go.Scatter(x=np.round(x, 4), y=np.round(y, 3), name=name, mode="lines", line=line)
        figure.add_trace(trace, row=1, col=1)
    for flag, colour in STATES.items():
        x, y = _bars(t_s, flags & int(flag) != 0, words.FLAG_WORDS[flag])
        if len(x):
            bar = {"color": colour, "width": 9}
            trace = go.Scatter(x=x, y=y, mode="lines", line=bar, showlegend=False, hoverinfo="y")
            figure.add_trace(trace, row=2, col=1)
    for at, (axis, colour) in enumerate(AXIS_COLOURS.items()):
        trace = go.Scatter(
            x=[round(t, 3) for t, _status in statuses],
            y=[round(words.bias_deg_s(status)[at], 4) for _t, status in statuses],
            name=f"bias {axis}",
            mode="lines+markers",
            line={"color": colour, "width": 1.2},
            marker={"size": 4},
        )
        figure.add_trace(trace, row=3, col=1)
    figures.style(figure, height=720)
    figure.update_layout(hovermode="closest")
    figure.update_yaxes(title_text="angle / °", row=1, col=1)
    figure.update_yaxes(title_text="bias / (°/s)", row=3, col=1)
    figure.update_xaxes(title_text="device time / s", row=3, col=1)
    return figure


def _bars(t_s: np.ndarray, is_set: np.ndarray, name: str) -> tuple[list, list]:
    """Lines over the stretches in which a flag is set, with breaks between them."""
    edges = np.diff(np.concatenate([[0], is_set.astype(np.int8), [0]]))
    begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    x: list[float | None] = []
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        last_s = max(float(t_s[end - 1]), float(t_s[begin]) + RATE_OF_BAR_S)
        x += [round(float(t_s[begin]), 3), round(last_s, 3), None]
    return x, [name if value is not None else None for value in x]


def _facts(t_s, quats: np.ndarray, flags: np.ndarray, inertial: Inertial) -> list[list[str]]:
    tilt = rotation.tilt_deg(quats)
    span_s = float(t_s[-1] - t_s[0])
    rows = [
        ["attitudes", f"{len(t_s)}" + (f", {len(t_s) / span_s:.1f} a second" if span_s else "")],
        ["raw samples of the IMU", str(len(inertial.imu["sample"])) or "none"],
        ["tilt at the end", words.tilt_words(float(tilt[-1]))],
        ["largest tilt", f"{tilt.max():.2f}°"],
    ]
    for flag in STATES:
        count = int(np.count_nonzero(flags & int(flag)))
        if count:
            name = f"{count / len(flags):.1%} of the attitudes"
            if flag & words.ALARMING:
                name = f'<span class="never">{count}</span> of the attitudes'
            rows.append([words.FLAG_WORDS[flag], name])
    return rows


def _health(inertial: Inertial) -> str:
    told = [one.message for _order, one in inertial.told if isinstance(one.message, ImuStatus)]
    if not told:
        return parts.note("The recording holds no IMU_STATUS.")
    status = told[-1]
    rows = [["part", html.escape(words.part_words(status))]]
    if warning := words.identity_warning(status):
        rows.append(["", f'<span class="never">{html.escape(warning)}</span>'])
    rows.append(["magnetometer", html.escape(words.magnetometer_words(status))])
    plain = plain_message(status)
    for name in ("samples", *words.COUNTERS):
        shown, text = name.replace("_", " "), str(plain[name])
        is_bad = shown in words.trouble(status)
        rows.append([shown, f'<span class="never">{text}</span>' if is_bad else text])
    return parts.table(["IMU at the end of the recording", ""], rows)
