# SPDX-License-Identifier: MIT
"""What really lay on the scale, where somebody knows: a CSV of the bench or of one's own making.

Columns: t_s (seconds), load_g (gram on the scale), and optionally counts (what the converter
should give). Its clock is fitted to the recording's by the signal itself, since neither knows the
other's zero.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from terazi.errors import CannotRead
from terazi.recorder.files import cannot_read

ALIGN_STEP_S = 0.001  # how finely the clocks are fitted in the end


@dataclass(frozen=True)
class Truth:
    """load_g over t_s, held between rows."""

    t_s: np.ndarray
    load_g: np.ndarray

    def at(self, t_s: np.ndarray) -> np.ndarray:
        """The load at these times; NaN where the truth says nothing."""
        index = np.searchsorted(self.t_s, t_s, side="right") - 1
        known = (index >= 0) & (t_s <= self.t_s[-1])
        return np.where(known, self.load_g[np.clip(index, 0, None)], np.nan)

    def shifted(self, by_s: float) -> "Truth":
        """The same, on a clock whose zero lies by_s earlier."""
        return Truth(self.t_s + by_s, self.load_g)


def load_truth(path: Path) -> Truth:
    """Read a truth file. Raises CannotRead with the line that is wrong."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            rows = csv.DictReader(line for line in file if not line.startswith("#"))
            missing = {"t_s", "load_g"} - set(rows.fieldnames or [])
            if missing:
                raise CannotRead(f"{path} has no column {' and no column '.join(sorted(missing))}")
            pairs = [_pair(path, rows.line_num, row) for row in rows]
    except OSError as error:
        raise cannot_read(path, error) from error
    except UnicodeDecodeError as error:
        raise CannotRead(f"{path} is not a text file") from error
    if len(pairs) < 2:
        raise CannotRead(f"{path} holds fewer than two rows")
    t_s, load_g = np.array(pairs).T
    if np.any(np.diff(t_s) < 0):
        raise CannotRead(f"{path}: t_s does not always grow")
    return Truth(t_s, load_g)


def _pair(path: Path, line: int, row: dict) -> tuple[float, float]:
    try:
        pair = float(row["t_s"]), float(row["load_g"])
    except (TypeError, ValueError) as error:
        raise CannotRead(f"{path}, line {line}: not a number") from error
    if not np.all(np.isfinite(pair)):
        raise CannotRead(f"{path}, line {line}: not a finite number")
    return pair


def align(truth: Truth, t_s: np.ndarray, measured_g: np.ndarray, rate_hz: float) -> float:
    """Seconds to add to the truth's clock so that it fits the measurement best.

    t_s, measured_g : (n,) float64, growing time, raw weight.

    The shift that makes the correlation of the two largest, first on a grid of samples, then in
    milliseconds around the best. 0 if the truth never changes: then every shift fits.
    """
    if np.ptp(truth.load_g) == 0.0:
        return 0.0
    grid_s = 1.0 / rate_hz
    # Both on one grid, each from its own beginning, means taken off, zeros beyond the ends.
    measured = np.interp(np.arange(t_s[0], t_s[-1], grid_s), t_s, measured_g)
    known_s = np.arange(truth.t_s[0], truth.t_s[-1], grid_s)
    known = truth.at(known_s)
    size = 1 << (len(measured) + len(known)).bit_length()
    spectrum = np.fft.rfft(measured - measured.mean(), size)
    correlation = np.fft.irfft(spectrum * np.conj(np.fft.rfft(known - known.mean(), size)), size)
    lag = int(np.argmax(correlation))
    lag -= size if lag > size // 2 else 0
    coarse_s = t_s[0] - truth.t_s[0] + lag * grid_s
    fine_s = coarse_s + np.arange(-1.5 * grid_s, 1.5 * grid_s, ALIGN_STEP_S)
    misfits = [_misfit(truth.shifted(by_s), t_s, measured_g) for by_s in fine_s]
    best = np.flatnonzero(np.array(misfits) <= min(misfits) * (1 + 1e-9))
    return float(fine_s[best].mean())  # between two samples every shift fits the same


def _misfit(truth: Truth, t_s: np.ndarray, measured_g: np.ndarray) -> float:
    known = truth.at(t_s)
    there = np.isfinite(known)
    difference = measured_g[there] - known[there]
    return float(np.var(difference)) if there.any() else np.inf
