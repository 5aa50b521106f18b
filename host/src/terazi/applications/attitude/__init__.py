# SPDX-License-Identifier: MIT
"""Attitude: recordings with a known orientation through the chip's own filters, and their errors.

Formats: trials.py.  What is run: chain.py.  How errors are defined: score.py.
"""

from terazi.applications.attitude.chain import FILTERS, MODES, estimate
from terazi.applications.attitude.records import Record, load_record
from terazi.applications.attitude.score import Errors, Score, attitude_errors, score
from terazi.applications.attitude.trials import Trial, find_trials, load_trial

__all__ = [
    "FILTERS",
    "MODES",
    "Errors",
    "Record",
    "Score",
    "Trial",
    "attitude_errors",
    "estimate",
    "find_trials",
    "load_record",
    "load_trial",
    "score",
]
