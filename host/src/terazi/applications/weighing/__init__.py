# SPDX-License-Identifier: MIT
"""Weighing: what each filter makes of steps between loads, noise and a belt that hums."""

from terazi.applications.weighing.experiment import Experiment
from terazi.applications.weighing.score import Score, score

__all__ = ["Experiment", "Score", "score"]
