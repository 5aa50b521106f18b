# SPDX-License-Identifier: MIT
"""A view's figures, for the terminal, the page and scripts."""

from __future__ import annotations

import dataclasses

import numpy as np

from terazi.applications.attitude.view import View
from terazi.control import inertial as words
from terazi.units import show_duration

ANGLES = ("roll", "pitch", "yaw")
FLAG_WORDS = {
    "rest": "at rest",
    "bias_known": "bias known",
    "still": "still",
    "heading": "heading from a magnetometer",
    "disturbed": "field disturbed",
    "gap": "samples lost",
    "railed": "beyond its range",
    "restarted": "inclination set anew",
}


def plain(view: View) -> dict:
    """What `terazi attitude FILE --json` prints."""
    euler = view.euler_deg
    found = {
        "name": view.name,
        "source": view.source,
        "duration_s": float(view.t_s[-1]),
        "attitudes": len(view.t_s),
        "rate_hz": view.rate_hz,
        "angles_deg": {
            name: {
                "first": float(column[0]),
                "last": float(column[-1]),
                "least": float(column.min()),
                "most": float(column.max()),
            }
            for name, column in zip(ANGLES, euler.T, strict=True)
        },
        "tilt_deg": {"median": float(np.median(view.tilt_deg)), "most": float(view.tilt_deg.max())},
        "share_of_time": {name: view.share(name) for name in view.flags},
        "rate_most_deg_s": view.rate_most_deg_s,
        "bias_deg_s": view.bias_deg_s[-1].tolist() if len(view.bias_deg_s) else None,
        "errors": None if view.errors is None else dataclasses.asdict(view.errors),
        "trouble": {} if view.status is None else words.trouble(view.status),
        "notes": view.notes,
    }
    if view.sensors is not None and view.sensors.mag_b_ut is not None:
        lengths = np.linalg.norm(view.sensors.mag_b_ut, axis=1)
        found["field_ut"] = {"mean": float(lengths.mean()), "sd": float(lengths.std())}
    return found


def rows(view: View) -> list[tuple[str, str]]:
    """What a table of two columns says."""
    figures = plain(view)
    told = [
        ("attitudes", f"{figures['attitudes']}, {view.source}"),
        ("recorded", f"{show_duration(figures['duration_s'])} at {view.rate_hz:.5g} a second"),
    ]
    for name, angle in figures["angles_deg"].items():
        told.append(
            (name, f"{angle['least']:+.2f} to {angle['most']:+.2f} deg, ends {angle['last']:+.2f}")
        )
    tilt = figures["tilt_deg"]
    told.append(("off the vertical", f"{tilt['median']:.2f} deg, {tilt['most']:.2f} deg at most"))
    told.append(("turns", f"{figures['rate_most_deg_s']:.1f} deg/s at most on an axis"))
    if figures["bias_deg_s"] is not None:
        bias = " ".join(f"{value + 0.0:+.3f}" for value in figures["bias_deg_s"])
        told.append(("gyroscope's bias", f"{bias} deg/s at the end"))
    for name, share in figures["share_of_time"].items():
        told.append((FLAG_WORDS[name], f"{share:.1%} of the time"))
    if "field_ut" in figures:
        field = figures["field_ut"]
        told.append(("field", f"{field['mean']:.1f} uT, {field['sd']:.1f} uT rms about it"))
    if view.errors is not None:
        told += [
            (f"{name.split('_')[0]} error", f"{value:.2f} deg rms, while it moves")
            for name, value in figures["errors"].items()
        ]
    told += [(name, str(count)) for name, count in figures["trouble"].items()]
    return told
