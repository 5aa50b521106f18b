# SPDX-License-Identifier: MIT
"""A recording to calibrate by, and the calibration that held while it was made."""

from __future__ import annotations

from pathlib import Path

from terazi.applications.attitude.calibrated import told_settings
from terazi.applications.attitude.records import Record, load_npz, of_inertial
from terazi.recorder import load_recording


def read(path: Path) -> tuple[Record, dict[str, int] | None]:
    """A capture or an .npz; with settings by name where the capture tells them, else None.

    Raises CannotRead.
    """
    if path.suffix == ".npz":
        return load_npz(path), None
    inertial = load_recording(path, needs_samples=False).inertial
    return of_inertial(inertial, path.name), told_settings(inertial)
