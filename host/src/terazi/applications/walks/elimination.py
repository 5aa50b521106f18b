# SPDX-License-Identifier: MIT
"""Heuristic drift elimination, the article's: corridors are straight and meet at right angles.

1. Of the first five strides, each two neighbours must differ by less than `straight_rad`: then the
   walker goes straight, and their sum, projected on the plan, is the dominant direction.
2. A later stride that is as straight as that belongs to a run. A run of at least `run_len` strides
   is turned to the nearest dominant direction (the first, and what is a quarter turn from it).
3. Every stride is turned about the vertical by what its run was, strides between runs by what
   lies between; heights stay, so that stairs keep their climb and get their direction.

The gate: a gyroscope drifts slowly and steadily; people turn as they like. So the offsets of the
runs must lie on one straight line over time within `misfit_rad`, its slope at most `drift_rad_s`,
strides of a run must not bend more than that, and most of the way must lie in runs. Where any of
these fails the path is left as it is, and the words say why.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from terazi.applications.walks.navigator import Path
from terazi.applications.walks.steps import Strides

QUARTER = np.pi / 2
SURE = 2.0  # sigmas


@dataclass(frozen=True)
class EliminationSettings:
    """Angles between strides, and what a gyroscope may do."""

    first_len: int = 5
    straight_rad: float = np.radians(15.0)
    run_len: int = 4
    drift_rad_s: float = np.radians(1.0)
    misfit_rad: float = np.radians(4.0)
    least_rad: float = np.radians(3.0)  # in all: less is not worth the risk
    in_runs: float = 0.55  # share of the strides


@dataclass(frozen=True)
class Elimination:
    """The path, turned or not, and what was done."""

    path: Path
    applied: bool
    words: str


def _wrapped(angle):
    return (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi


def _offset(angle):
    """From the nearest dominant direction, -pi/4..pi/4."""
    return (np.asarray(angle) + QUARTER / 2) % QUARTER - QUARTER / 2


def runs(headings: np.ndarray, settings: EliminationSettings) -> list[tuple[int, int]]:
    """Strides [begin, end) each of which goes where the one before went."""
    bends = np.abs(_wrapped(np.diff(headings))) < settings.straight_rad
    found, begin = [], 0
    for at in range(1, len(headings) + 1):
        if at == len(headings) or not bends[at - 1]:
            low, high = _inner(headings[begin:at], settings.straight_rad / 2)
            if high - low >= settings.run_len:
                found.append((begin + low, begin + high))
            begin = at
    return found


def _inner(headings: np.ndarray, most: float) -> tuple[int, int]:
    """Without strides at either end that still belong to a turn."""
    middle = np.median(np.unwrap(headings))
    good = np.flatnonzero(np.abs(_wrapped(headings - middle)) <= most)
    return (int(good[0]), int(good[-1]) + 1) if len(good) else (0, 0)


def eliminate(
    path: Path, strides: Strides, t_s: np.ndarray, settings: EliminationSettings | None = None
) -> Elimination:
    """Turn the path's strides to its dominant directions where the gate lets it."""
    settings = settings or EliminationSettings()
    vectors = strides.vectors_m
    if len(vectors) < settings.first_len + settings.run_len:
        return Elimination(path, False, f"{len(vectors)} strides are too few")
    headings = np.arctan2(vectors[:, 1], vectors[:, 0])
    first = np.abs(_wrapped(np.diff(headings[: settings.first_len])))
    if (first >= settings.straight_rad).any():
        return Elimination(path, False, "it does not start straight")
    begin = vectors[: settings.first_len, :2].sum(axis=0)
    dominant = np.arctan2(begin[1], begin[0])
    middle_s = (t_s[strides.at[:-1]] + t_s[strides.at[1:]]) / 2
    spans = runs(headings, settings)
    inside = sum(end - begin for begin, end in spans)
    if inside < settings.in_runs * len(vectors):
        return Elimination(path, False, f"only {inside} of {len(vectors)} strides are in line")
    refusal, line = _judge(headings - dominant, middle_s, spans, settings)
    if refusal:
        return Elimination(path, False, refusal)
    # The line's value where the path begins is the first strides' own error, not drift.
    dominant += np.polyval(line, middle_s[0])
    turns = -line[0] * (middle_s - middle_s[0])
    for begin, end in spans:
        turns[begin:end] += _rest_of_run(headings[begin:end] + turns[begin:end], dominant)
    words = f"{inside} strides turned, up to {np.degrees(np.abs(turns).max()):.1f} deg"
    return Elimination(_turned(path, strides, turns), True, words)


def _judge(headings, middle_s, spans, settings) -> tuple[str, np.ndarray]:
    """Why not, or an empty string; and the line of offset over time."""
    offsets, times, weights = [], [], []
    for begin, end in spans:
        within = np.unwrap(headings[begin:end])
        bend = np.polyfit(middle_s[begin:end] - middle_s[begin], within, 1)[0]
        noise = np.std(within) / max(middle_s[end - 1] - middle_s[begin], 1e-9)
        if abs(bend) > settings.drift_rad_s + 2 * noise / np.sqrt(end - begin):
            return f"a run bends by {np.degrees(bend):.2f} deg/s, more than a gyroscope does", None
        half = (begin + end) // 2
        for low, high in ((begin, half), (half, end)):
            offsets.append(np.angle(np.mean(np.exp(1j * within[low - begin : high - begin]))))
            times.append(middle_s[low:high].mean())
            weights.append(high - low)
    # Follow the drift from run to run, for it may come to exceed an eighth of a turn.
    times, weights = np.array(times), np.array(weights, dtype=float)
    followed = np.empty(len(offsets))
    followed[0] = _offset(offsets[0])
    for at in range(1, len(offsets)):
        followed[at] = followed[at - 1] + _offset(offsets[at] - followed[at - 1])
    line = np.polyfit(times, followed, 1, w=np.sqrt(weights))
    misfit = np.abs(followed - np.polyval(line, times))
    if abs(line[0]) > settings.drift_rad_s:
        return f"headings drift by {np.degrees(line[0]):.2f} deg/s, more than a gyroscope", line
    grown = abs(line[0]) * (times[-1] - times[0])
    if grown < max(settings.least_rad, SURE * np.std(followed - np.polyval(line, times))):
        return f"headings drift by {np.degrees(grown):.1f} deg in all: nothing to eliminate", line
    if (misfit * np.sqrt(weights / weights.max())).max() > settings.misfit_rad:
        return f"runs lie {np.degrees(misfit.max()):.1f} deg off a steady drift", line
    return "", line


def _rest_of_run(headings, dominant: float) -> float:
    """What the run's mean heading still lacks to the dominant direction nearest to it."""
    return -float(_offset(np.angle(np.mean(np.exp(1j * headings))) - dominant))


def _turned(path: Path, strides: Strides, turns: np.ndarray) -> Path:
    """Every stride's part of the path, turned; what is outside goes with its neighbour."""
    stride = np.clip(
        np.searchsorted(strides.at, np.arange(len(path.pos_w_m)), side="left") - 1,
        0,
        len(turns) - 1,
    )
    cos, sin = np.cos(turns[stride]), np.sin(turns[stride])

    def turn(vectors):
        x, y = vectors[:, 0], vectors[:, 1]
        return np.column_stack([cos * x - sin * y, sin * x + cos * y, vectors[:, 2]])

    moved = np.diff(path.pos_w_m, axis=0, prepend=path.pos_w_m[:1])
    half = turns[stride] / 2
    scalar, along = np.cos(half)[:, None], np.sin(half)[:, None]
    w, x, y, z = path.quat_wb.T[:, :, None]
    quat = np.hstack(
        [scalar * w - along * z, scalar * x - along * y, scalar * y + along * x,
         scalar * z + along * w]
    )  # fmt: skip
    pos = path.pos_w_m[0] + np.cumsum(turn(moved), axis=0)
    return replace(path, pos_w_m=pos, vel_w_m_s=turn(path.vel_w_m_s), quat_wb=quat)
