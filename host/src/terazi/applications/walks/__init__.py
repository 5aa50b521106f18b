# SPDX-License-Identifier: MIT
"""Walks: an inertial sensor on a foot becomes a path. README.md says how, and how well."""

from terazi.applications.walks.estimate import ALL_DETECTORS, NAVIGATORS, Options, Result, estimate
from terazi.applications.walks.formats import find_walks, load_walk
from terazi.applications.walks.record import Truth, Walk
from terazi.applications.walks.score import Errors, Score, path_errors, score
from terazi.applications.walks.summary import Summary, summarise

__all__ = [
    "ALL_DETECTORS",
    "NAVIGATORS",
    "Errors",
    "Options",
    "Result",
    "Score",
    "Summary",
    "Truth",
    "Walk",
    "estimate",
    "find_walks",
    "load_walk",
    "path_errors",
    "score",
    "summarise",
]
