# SPDX-License-Identifier: MIT
"""Settings and calibration of a device, and what a file would change."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass

from terazi.calibration.session import Session
from terazi.control.balance import Balance
from terazi.control.setting_text import show_with_unit
from terazi.control.settings import apply_settings, read_settings
from terazi.errors import TeraziError
from terazi.link import Link
from terazi.link.generated.messages import Point
from terazi.link.generated.settings import SETTINGS, SETTINGS_BY_NAME
from terazi.settings.text import CALIBRATION, POINTS, SettingsFile, points_of


@dataclass(frozen=True)
class Change:
    """One difference, before and after in words."""

    name: str
    before: str
    now: str

    def __str__(self) -> str:
        return f"{self.name}: {self.before} -> {self.now}"


def read_device(link: Link) -> dict[str, int]:
    """Every setting by full name, the calibration's points among them."""
    return read_settings(link, [setting.full_name for setting in SETTINGS])


def differences(values: Mapping[str, int], file: SettingsFile) -> list[Change]:
    """What the file would change in a device that holds these values."""
    changes = []
    for name, now in file.settings.items():
        if values[name] != now:
            setting = SETTINGS_BY_NAME[name]
            words = (show_with_unit(setting, value) for value in (values[name], now))
            changes.append(Change(name, *words))
    if _other_points(values, file):
        words = (_points_text(points) for points in (points_of(values), file.points))
        changes.append(Change(f"{CALIBRATION}.{POINTS}", *words))
    return changes


def apply_file(balance: Balance, file: SettingsFile) -> list[Change]:
    """Make a device hold what a file says; gives what has changed.

    All of it or nothing. Settings are not saved yet; a calibration that changes saves itself, and
    the settings with it. Raises CommandRefused, which names what the device refuses.
    """
    values = read_device(balance.link)
    changes = differences(values, file)
    before = apply_settings(balance.link, file.settings)
    if _other_points(values, file):
        try:
            with Session(balance) as session:
                for point in file.points:
                    session.know(point)
                session.end()
        except TeraziError:
            # The link may be what failed: then the device forgets at its next reset.
            with contextlib.suppress(TeraziError):
                apply_settings(balance.link, before)
            raise
    return changes


def _other_points(values: Mapping[str, int], file: SettingsFile) -> bool:
    return file.points is not None and file.points != points_of(values)


def _points_text(points: tuple[Point, ...]) -> str:
    masses = ", ".join(f"{point.mass_mg / 1000:g}" for point in points)
    return f"{len(points)} points ({masses} g)"
