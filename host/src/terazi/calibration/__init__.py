# SPDX-License-Identifier: MIT
"""Calibration as a dialogue: what to put on, whether the points go together, what came of it.

points     what a set of points is worth, and what is wrong with a new one
dialogue   the conversation, over a `Terminal` and a link
terminal   what the conversation needs of a terminal: tell, ask, pause
"""

from terazi.calibration.dialogue import Plan, calibrate
from terazi.calibration.points import Finding, Residual, examine, residuals
from terazi.calibration.terminal import Terminal

__all__ = ["Finding", "Plan", "Residual", "Terminal", "calibrate", "examine", "residuals"]
