# SPDX-License-Identifier: MIT
"""What the screen shows, as lines of text: no terminal is needed to make them."""

from __future__ import annotations

import numpy as np
from rich.text import Text

from terazi.control import faults
from terazi.control.balance import SILENCE_S
from terazi.control.display import marks, shown, temperature_deg_c
from terazi.control.inertial import ALARMING, MPU6050, flag_words, state_words
from terazi.link.generated.messages import ImuState
from terazi.live.session import Session
from terazi.rotation import euler_deg, tilt_deg, up_b

BUBBLE_WIDTH, BUBBLE_HEIGHT = 21, 7
BUBBLE_DEG = 10.0  # of tilt at the rim


def weight_digits(session: Session) -> str:
    """The display's number and unit; dashes where nothing is to be shown."""
    balance = session.watch.balance
    if balance.weight is None or balance.silent_s > SILENCE_S:
        return "- - -"
    return shown(balance.weight)


def weight_words(session: Session) -> Text:
    """What stands beside the number."""
    balance = session.watch.balance
    if session.is_text:
        return Text("text mode: the board sends lines, no weight", style="yellow")
    if balance.weight is None or balance.silent_s > SILENCE_S:
        return Text(f"no weight for {balance.silent_s:.0f} s", style="bold red")
    if spoilt := faults.names(balance.weight.faults & faults.SPOILING):
        return Text(f"no weight to be trusted: {', '.join(spoilt)}", style="bold red")
    words = marks(balance.weight)
    row = Text(words[0], style="bold green" if words[0] == "stable" else "bold yellow")
    for word in words[1:]:
        row.append(f"   {word}", style="bold red" if word in ("over", "under") else "cyan")
    return row


def health(session: Session) -> Text:
    """One line: converter's rate, temperature, frames lost, recording."""
    watch = session.watch
    words = [f"{watch.rate_hz:.2f} SPS" if watch.rate_hz else "rate not known yet"]
    degrees = temperature_deg_c(watch.balance.weight) if watch.balance.weight else None
    if degrees is not None:
        words.append(f"{degrees:.1f} °C")
    if watch.status is not None:
        words.append(f"{watch.status.cpu_busy_permille / 10:.0f} % busy")
    lost = session.link.stream.frames_lost
    row = Text("  ".join([*words, f"{lost} frames lost"]), style="red" if lost else "dim")
    recorder = session.recorder
    if recorder is not None:
        row.append(f"  ● recording, {recorder.samples} samples", style="bold red")
    return row


def fault_line(session: Session) -> Text:
    """The faults that hold, by name; f shows what to do."""
    held = faults.names(session.watch.faults)
    if not held:
        return Text("no fault", style="green")
    return Text(f"fault (f: what to do): {', '.join(held)}", style="bold red")


def fault_list(session: Session) -> Text:
    """Each fault that holds, what it means and what to do."""
    rows = Text()
    for name, what, remedy in faults.explained(session.watch.faults):
        rows.append(f"{name}: {what}\n", style="bold red")
        rows.append(f"  {remedy}\n", style="yellow")
    status = session.watch.status
    held = session.watch.faults
    before = faults.names(status.faults_seen & ~int(held)) if status else []
    if not rows:
        rows.append("No fault holds.\n", style="green")
    if before:
        rows.append(f"Since the board's start, and over: {', '.join(before)}\n", style="dim")
    return rows


def attitude_quat(session: Session) -> np.ndarray | None:
    """The newest quaternion, body to world; None where none has come of late."""
    if not session.has_attitude:
        return None
    told = session.attitude.message
    parts = (told.quat_w_q30, told.quat_x_q30, told.quat_y_q30, told.quat_z_q30)
    return np.array([parts], dtype=np.float64)


def angles(session: Session) -> Text:
    """Roll, pitch, yaw and tilt, a line each, and what the attitude's flags say."""
    if session.is_text:
        return Text("text mode: the board sends lines, no attitude", style="yellow")
    quat = attitude_quat(session)
    if quat is None:
        return Text(_why_no_attitude(session), style="dim")
    rows = Text()
    values = [*euler_deg(quat)[0], tilt_deg(quat)[0]]
    for name, value in zip(("roll", "pitch", "yaw", "tilt"), values, strict=True):
        rows.append(f"{name:<6}{value:8.2f} °\n", style="bold")
    rows.append_text(attitude_words(session))
    return rows


def _why_no_attitude(session: Session) -> str:
    imu = session.imu
    if session.is_narrow:
        return "no attitude: the line has no room for it"
    if imu is None:
        return "no attitude: no IMU was seen"
    if imu.state != ImuState.RUNNING:
        return f"no attitude: the IMU is {state_words(imu)}"
    return "no attitude: imu.mode is off, or the board is silent"


def attitude_words(session: Session) -> Text:
    """What holds on one line, what is amiss on the next."""
    flags = session.attitude_flags
    words = Text("  ".join(flag_words(flags & ~int(ALARMING))), style="green")
    amiss = "  ".join(flag_words(flags & int(ALARMING)))
    return words.append(f"\n{amiss}", style="bold red")


def imu_line(session: Session) -> Text:
    """The IMU in one line: identity, rates, what was lost."""
    imu = session.imu
    if imu is None:
        return Text("no IMU", style="dim")
    name = "MPU-6050" if imu.identity == MPU6050 else f"IMU 0x{imu.identity:02X}"
    words = [f"{name} {state_words(imu)}", f"{session.attitude_rate_hz:.0f} ATTITUDE/s"]
    kind = getattr(imu.mag_kind, "name", "none")
    if kind.lower() != "none":
        words.append(kind)
    if imu.missed or imu.losses:
        away = f"{imu.losses} times" if imu.losses != 1 else "once"
        words.append(f"{imu.missed} samples lost, {away} away")
    return Text("  ".join(words), style="dim")


def bubble(session: Session) -> Text:
    """A bubble level: where the vertical leaves the board, seen from above, 10 deg at the rim."""
    rows = [[" "] * BUBBLE_WIDTH for _ in range(BUBBLE_HEIGHT)]
    mid_x, mid_y = BUBBLE_WIDTH // 2, BUBBLE_HEIGHT // 2
    rows[mid_y] = list("·" * BUBBLE_WIDTH)
    for row in rows:
        row[mid_x] = "·"
    quat = attitude_quat(session)
    style = "dim"
    if quat is not None:
        x, y, _z = up_b(quat)[0]
        rim = np.sin(np.radians(BUBBLE_DEG))
        right = round(np.clip(x / rim, -1, 1) * mid_x)  # the bubble stands where it is high
        above = round(np.clip(y / rim, -1, 1) * mid_y)
        rows[mid_y - above][mid_x + right] = "●"
        style = "bold green" if right == above == 0 else "bold yellow"
    return Text("\n".join("".join(row) for row in rows), style=style)
