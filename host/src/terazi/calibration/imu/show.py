# SPDX-License-Identifier: MIT
"""What a calibration of the IMU came to, on a terminal and for scripts."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from terazi.calibration.imu.fit import FieldResult, MotionResult
from terazi.calibration.imu.quantise import Constants
from terazi.calibration.terminal import Terminal
from terazi.errors import TeraziError
from terazi.units import ACC_COUNTS_PER_STANDARD_GRAVITY as ONE_G


def error(terminal: Terminal, what: TeraziError) -> None:
    """What is wrong, and what to do."""
    text = str(what)
    terminal.tell(text[0].upper() + text[1:], tone="bad")
    if what.remedy:
        terminal.tell(what.remedy, tone="soft")


def outcome(terminal: Terminal, motion: MotionResult | None, field: FieldResult | None) -> None:
    """Residuals before and after."""
    if motion is not None:
        _motion(terminal, motion)
    if field is not None:
        _field(terminal, field)
    for result in (motion, field):
        for note in result.notes if result is not None else []:
            terminal.tell(note[0].upper() + note[1:] + ".", tone="warn")


def _motion(terminal: Terminal, result: MotionResult) -> None:
    rows = [
        (
            one.name,
            f"{one.seconds:.1f} s",
            f"{one.before_g * 1000:+.2f} mg",
            f"{one.after_g * 1000:+.2f} mg",
        )
        for one in result.positions
    ]
    terminal.table(("up", "still", "gravity off, before", "after"), rows)
    offset_mg = result.acc.constants.offset_counts / ONE_G * 1000
    before_mg, after_mg = (result.rms_g(which) * 1000 for which in ("before_g", "after_g"))
    terminal.tell(
        f"Accelerometer: offset {_axes(offset_mg, '.1f')} mg, scale "
        f"{_axes(_scale(result.acc.constants), '+.2f')} %; gravity is off by {before_mg:.2f} mg "
        f"rms before, {after_mg:.2f} mg after."
    )
    words = f"{_axes(result.bias_before_deg_s, '+.3f')} deg/s before, "
    words += f"{_axes(result.bias_after_deg_s, '+.3f')} after"
    terminal.tell(f"Gyroscope: at rest {words}.")
    if result.gyro.is_matrix_known:
        terminal.tell(
            f"Its scale {_axes(_scale(result.gyro.constants), '+.2f')} %, by {result.gyro.turns} "
            f"turns; they miss gravity by {result.turns_before_deg:.2f} deg before, "
            f"{result.turns_after_deg:.2f} deg after."
        )


def _field(terminal: Terminal, result: FieldResult) -> None:
    offset = _axes(result.mag.constants.offset_counts, ".0f")
    terminal.tell(
        f"Magnetometer: hard iron {offset} counts, a field of {result.mag.field_counts:.0f}; its "
        f"length differs by {result.rms_before:.2%} rms before, {result.rms_after:.2%} after (at "
        f"most {result.worst_before:.1%}, {result.worst_after:.1%})."
    )


def _scale(constants: Constants) -> np.ndarray:
    """By how much the part reads too much on each axis, in percent."""
    return (1 / np.diag(constants.matrix) - 1) * 100


def _axes(values: np.ndarray, form: str) -> str:
    return " ".join(format(float(value) + 0.0, form) for value in values)


def settings(terminal: Terminal, values: Mapping[str, int]) -> None:
    """Line by line, as `terazi set` takes them."""
    for name, value in values.items():
        terminal.tell(f"{name}={value}")


def plain(motion: MotionResult | None, field: FieldResult | None, saved: int | None) -> dict:
    """What --json prints."""
    found: dict = {"settings": {}, "settings_saved": saved, "notes": []}
    for result in (motion, field):
        if result is not None:
            found["settings"] |= result.settings
            found["notes"] += result.notes
    if motion is not None:
        found["accelerometer"] = _constants(motion.acc.constants) | {
            "positions": [vars(one) for one in motion.positions],
            "rms_before_g": motion.rms_g("before_g"),
            "rms_after_g": motion.rms_g("after_g"),
            "offset_sd_g": motion.acc.offset_sd_g,
            "scale_sd": motion.acc.scale_sd,
            "cross_sd": motion.acc.cross_sd,
        }
        found["gyroscope"] = _constants(motion.gyro.constants) | {
            "bias_before_deg_s": motion.bias_before_deg_s.tolist(),
            "bias_after_deg_s": motion.bias_after_deg_s.tolist(),
            "is_matrix_known": motion.gyro.is_matrix_known,
            "turns": motion.gyro.turns,
            "turns_before_deg": _finite(motion.turns_before_deg),
            "turns_after_deg": _finite(motion.turns_after_deg),
        }
    if field is not None:
        found["magnetometer"] = _constants(field.mag.constants) | {
            "field_counts": field.mag.field_counts,
            "rms_before": field.rms_before,
            "rms_after": field.rms_after,
            "left_out": field.mag.left_out,
        }
    return found


def _constants(constants: Constants) -> dict:
    return {
        "matrix": constants.matrix.tolist(),
        "offset_counts": constants.offset_counts.tolist(),
    }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
