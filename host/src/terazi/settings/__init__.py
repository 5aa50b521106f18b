# SPDX-License-Identifier: MIT
"""The device's settings and calibration as a TOML file: written, read strictly, compared, applied.

    [scale]
    max_mg = 5000000        # group.name is the setting's name everywhere

    [calibration]
    points = [{ counts_q7 = 0, mass_mg = 0 }, { counts_q7 = 274914089, mass_mg = 5000000 }]

A file may hold only some of the settings; the others stay. What the device alone writes (zero,
tare) is told in comments.
"""

from terazi.settings.device import Change, apply_file, differences, read_device
from terazi.settings.text import SettingsFile, parse_settings, read_settings_file, render_settings

__all__ = [
    "Change",
    "SettingsFile",
    "apply_file",
    "differences",
    "parse_settings",
    "read_device",
    "read_settings_file",
    "render_settings",
]
