# SPDX-License-Identifier: MIT
"""CSV of an inertial sensor, by a layout: which column is what, and in which unit.

    [time]                          # or rate_hz = 256 at the top, for rows at a constant rate
    column = "Time (s)"
    unit = "s"                      # s, ms, us
    [acceleration]
    columns = ["ax", "ay", "az"]    # by heading, or by number from 0 where there are no headings
    unit = "g"                      # g, mg, m/s^2, counts (then also per_unit, counts a g)
    [rate]
    columns = ["gx", "gy", "gz"]
    unit = "deg/s"                  # deg/s, rad/s, mdeg/s, counts (per_unit: counts a deg/s)
    [magnetic]                      # optional
    columns = ["mx", "my", "mz"]

A "-" before a heading turns that axis round. Without a layout, the headings of x-io's sensors are
known ("Time (s)" or "Packet number", "Gyroscope X (deg/s)", "Accelerometer X (g)"), and those of
the NAME.imu.csv that `terazi log --imu` writes beside a capture.
"""

from __future__ import annotations

import csv
import tomllib
from pathlib import Path

import numpy as np

from terazi.applications.walks.checks import sane_rate
from terazi.applications.walks.record import Walk
from terazi.errors import CannotRead, UsageError

GRAVITY_M_S2 = 9.80665  # of the unit g
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
ACC_UNITS = {"m/s^2": 1.0, "g": GRAVITY_M_S2, "mg": GRAVITY_M_S2 / 1000, "counts": GRAVITY_M_S2}
RATE_UNITS = {
    **{"rad/s": 1.0, "deg/s": np.pi / 180, "mdeg/s": np.pi / 180_000},
    "counts": np.pi / 180,
}
PACKETS_HZ = 256.0  # x-io's own, where packets are numbered
IRREGULAR = 0.5  # a step so much longer or shorter than usual is told


def _three(heading: str) -> list[str]:
    return [heading.replace("X", axis) for axis in "XYZ"]


X_IO = {
    "time": {"column": "Time (s)", "unit": "s"},
    "acceleration": {"columns": _three("Accelerometer X (g)"), "unit": "g"},
    "rate": {"columns": _three("Gyroscope X (deg/s)"), "unit": "deg/s"},
}
X_IO_PACKETS = {**X_IO, "magnetic": {"columns": _three("Magnetometer X (G)")}}
del X_IO_PACKETS["time"]
IMU_TABLE = {
    "time": {"column": "device_s", "unit": "s"},
    "acceleration": {"columns": [f"acc_{axis}_m_s2" for axis in "xyz"], "unit": "m/s^2"},
    "rate": {"columns": [f"gyro_{axis}_deg_s" for axis in "xyz"], "unit": "deg/s"},
    "note": "a table knows no calibration: the capture beside it does",
}


def read_csv(path: Path, *, layout: Path | None = None, rate_hz: float | None = None) -> Walk:
    """Read one file; the walk is not checked yet."""
    headings, values, is_cut = _table(path)
    form = _layout(layout) if layout else _known(path, headings)
    notes: list[str] = [form["note"]] if "note" in form else []
    if is_cut:
        notes.append("the last row is cut off: left out")
    acc = _vector(path, headings, values, form, "acceleration", ACC_UNITS)
    gyro = _vector(path, headings, values, form, "rate", RATE_UNITS)
    mag = None
    if "magnetic" in form:
        mag = _vector(path, headings, values, form, "magnetic", {"": 1.0})
    if "time" in form:
        unit = form["time"].get("unit", "s")
        if unit not in TIME_UNITS:
            raise UsageError(f"time has no unit {unit!r}; there are {', '.join(TIME_UNITS)}")
        column = _column(path, headings, values, form["time"].get("column", "Time (s)"))
        t_s, kept = growing(path, column * TIME_UNITS[unit])
        if not kept.all():
            notes.append(f"{(~kept).sum()} rows bear the time of the row before: left out")
        acc, gyro = acc[kept], gyro[kept]
        mag = None if mag is None else mag[kept]
    else:
        rate_hz = rate_hz or form.get("rate_hz") or PACKETS_HZ
        t_s = np.arange(len(acc)) / float(rate_hz)
    walk = Walk(path.stem, t_s, acc, gyro, mag_b=mag, notes=tuple(notes))
    return regular(walk) if "time" in form and sane_rate(walk) else walk


def growing(path: Path, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times from 0 on, and which rows are kept: of equal times the first. Never backwards."""
    if len(t_s) < 2:
        raise CannotRead(f"{path}: holds {len(t_s)} samples")
    steps = np.diff(t_s)
    if not (steps >= 0).all():
        raise CannotRead(f"{path}: times run backwards at row {int(np.argmin(steps >= 0)) + 2}")
    kept = np.concatenate([[True], steps > 0])
    return t_s[kept] - t_s[0], kept


def regular(walk: Walk) -> Walk:
    """The same at the rate of its first seconds: straight lines between the samples."""
    usual_s = 1 / walk.rate_hz
    t_s = np.arange(0.0, walk.t_s[-1] + usual_s * 1e-6, usual_s)

    def at_new(values):
        if values is None:
            return None
        return np.column_stack([np.interp(t_s, walk.t_s, column) for column in values.T])

    notes = walk.notes
    steps_s = np.diff(walk.t_s)
    odd = int(np.sum(np.abs(steps_s - usual_s) > IRREGULAR * usual_s))
    if odd:
        longest = int(np.argmax(steps_s))
        words = f"{odd} steps of time are irregular, the longest {steps_s[longest]:.3g} s at "
        words += f"{walk.t_s[longest]:.1f} s: resampled at {1 / usual_s:.1f} Hz"
        notes = (*notes, words)
    return Walk(
        walk.name,
        t_s,
        at_new(walk.acc_b_m_s2),
        at_new(walk.gyro_b_rad_s),
        mag_b=at_new(walk.mag_b),
        notes=notes,
    )


def _table(path: Path) -> tuple[list[str], np.ndarray, bool]:
    """Headings, (n, k) texts, and whether a last row was cut off, as where a logger loses power."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            lines = [line for line in stream if line.strip() and not line.startswith("#")]
    except OSError as error:
        raise CannotRead(f"{path}: {error.strerror or error}") from None
    except UnicodeDecodeError as error:
        raise CannotRead(f"{path}: is no CSV in UTF-8: {error.reason}") from None
    if not lines:
        raise CannotRead(f"{path}: is empty")
    between = next((each for each in "\t;" if each in lines[0]), ",")
    if between == ";":  # where that separates, numbers may have a decimal comma
        lines = [lines[0], *(line.replace(",", ".") for line in lines[1:])]
    try:
        rows = csv.reader(lines, delimiter=between)
        headings = [each.strip() for each in next(rows)]
        body = list(rows)
    except csv.Error as error:
        raise CannotRead(f"{path}: is no CSV: {error}") from None
    if all(_is_number(each) for each in headings):
        body, headings = [headings, *body], [str(at) for at in range(len(headings))]
    is_cut = len(body) > 2 and len(body[-1]) < len(headings)
    if is_cut:
        body.pop()
    wrong = next((at for at, row in enumerate(body) if len(row) != len(headings)), None)
    if wrong is not None:
        raise CannotRead(
            f"{path}: row {wrong + 1} has {len(body[wrong])} fields, not {len(headings)}"
        )
    if len(body) < 2:
        raise CannotRead(f"{path}: holds fewer than two rows")
    return headings, np.array(body), is_cut


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _known(path: Path, headings: list[str]) -> dict:
    if {"device_s", *IMU_TABLE["acceleration"]["columns"]} <= set(headings):
        return IMU_TABLE
    if "Time (s)" in headings and X_IO["rate"]["columns"][0] in headings:
        return X_IO
    if "Packet number" in headings and X_IO["rate"]["columns"][0] in headings:
        present = all(each in headings for each in X_IO_PACKETS["magnetic"]["columns"])
        return X_IO_PACKETS if present else {k: v for k, v in X_IO.items() if k != "time"}
    raise CannotRead(
        f"{path}: its columns are not known: {', '.join(headings[:8])}",
        remedy="Name columns and units in a TOML and give it with --layout; see --help.",
    )


def _layout(path: Path) -> dict:
    try:
        form = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise CannotRead(f"{path}: {error.strerror or error}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise CannotRead(f"{path}: {error}") from None
    unknown = set(form) - {"rate_hz", "time", "acceleration", "rate", "magnetic"}
    missing = {"acceleration", "rate"} - set(form)
    if unknown or missing:
        words = [f"does not know {name!r}" for name in sorted(unknown)]
        words += [f"lacks [{name}]" for name in sorted(missing)]
        raise UsageError(f"{path}: a layout {' and '.join(words)}")
    if "time" not in form and "rate_hz" not in form:
        raise UsageError(f"{path}: a layout needs [time] or rate_hz")
    return form


def _vector(path, headings, values, form: dict, name: str, units: dict[str, float]) -> np.ndarray:
    """(n, 3) in SI."""
    section = form[name]
    columns = section.get("columns", ())
    unit = section.get("unit", "")
    if len(columns) != 3:
        raise UsageError(f"[{name}] must name three columns, not {len(columns)}")
    if unit not in units:
        raise UsageError(f"[{name}] has no unit {unit!r}; there are {', '.join(units)}")
    if unit == "counts" and not section.get("per_unit", 0) > 0:
        raise UsageError(f"[{name}] in counts needs per_unit, a positive number")
    scale = units[unit] / (section["per_unit"] if unit == "counts" else 1.0)
    return scale * np.column_stack([_column(path, headings, values, each) for each in columns])


def _column(path, headings: list[str], values: np.ndarray, heading) -> np.ndarray:
    heading = str(heading)
    sign = 1.0
    if heading not in headings and heading.startswith("-"):
        heading, sign = heading[1:], -1.0
    if heading not in headings:
        raise CannotRead(f"{path}: has no column {heading!r}; there are {', '.join(headings)}")
    texts = values[:, headings.index(heading)]
    try:
        column = sign * texts.astype(np.float64)
    except ValueError:
        column = np.array([float(each) if _is_number(each) else np.nan for each in texts])
    if not np.isfinite(column).all():
        row = int(np.argmax(~np.isfinite(column)))
        raise CannotRead(
            f"{path}: column {heading!r} holds no number in row {row + 1}: {str(texts[row])!r}",
            remedy="Leave such rows out: a gap in the times is bridged.",
        )
    return column
