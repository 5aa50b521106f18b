# SPDX-License-Identifier: MIT
"""Peaks of the angular rate that are beyond the gyroscope's range, put back.

A gyroscope at the end of its range tells a flat top. What is cut off there is turning that nobody
knows of, a degree or two in every stride of a runner, and by so much gravity leaks into the path.
The flanks say how high it would have been: in place of the flat top stands the cubic that meets the
samples beside it with the slopes that they have (Hermite). A peak that is round by itself comes out
as it is, for a cubic rises hardly above it.

What is a flat top is found without knowing the range: two samples or more, each as high as the axis
ever was on that side so far, and about as high as any axis ever was.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from terazi.applications.walks.windows import spans

# None of them is critical: none to 0.95 for OTHER_AXES, 0 to 0.06 for ABOVE, 0.97 to 0.985 for SAME
# and a third more or less of the times change mean errors of recorded walks by 2 to 4 %.
LEAST_RAD_S = 4.0  # 250 deg/s, the narrowest range in use on feet
SAME = 0.98  # samples of a top, by the highest one so far
OTHER_AXES = 0.9  # likewise, by the highest of all axes: each has a scale of its own
LOOK_S = 0.02  # after which the highest so far is
LONGEST_S = 0.1  # of a top; flanks know nothing of a longer one
SLOPE_S = 0.005  # of a flank, beside the top
ABOVE = 0.03  # the cubic rises by this share of the top's height, at least
AHEAD_S = LONGEST_S + LOOK_S + SLOPE_S
TOLD_FROM = 3  # peaks


@dataclass(frozen=True)
class Rates:
    """Angular rates in which peaks are put back.

    known_b_rad_s : (n, 3) in the end; row i depends on what is measured within AHEAD_S of it.
    at_once_b_rad_s : (n, 3) of which row i depends on samples 0 .. i alone: what a peak lacks comes
        in one sample, as soon as its far flank is seen.
    tops_rad_s : (k,) where the range ended, each time.
    """

    known_b_rad_s: np.ndarray
    at_once_b_rad_s: np.ndarray
    tops_rad_s: np.ndarray


def unclipped(measured: np.ndarray, rate_hz: float) -> Rates:
    """Put them back into (n, 3) rad/s."""
    known, at_once, tops = measured.copy(), measured.copy(), []
    longest = max(2, round(LONGEST_S * rate_hz))
    look = max(1, round(LOOK_S * rate_hz))
    slope_len = max(1, round(SLOPE_S * rate_hz))
    least = np.maximum(LEAST_RAD_S, OTHER_AXES * _highest(np.abs(measured).max(axis=1), look))
    for axis, sign in product(range(3), (1.0, -1.0)):
        rate = sign * measured[:, axis]
        high = rate >= np.maximum(least, SAME * _highest(rate, look))
        for begin, end in spans(high).tolist():
            seen = end + look + slope_len
            if not 2 <= end - begin <= longest or begin <= slope_len or seen >= len(rate):
                continue
            lacks = _lacking(rate, begin, end, slope_len)
            if lacks.max() >= ABOVE * rate[begin]:
                known[begin:end, axis] += sign * lacks
                at_once[seen, axis] += sign * lacks.sum()
                tops.append(rate[begin:end].max())
    return Rates(known, at_once, np.array(tops))


def clipping_note(rates: Rates) -> tuple[str, ...]:
    """What was done, where it was done more than once or twice."""
    tops = rates.tops_rad_s
    if len(tops) < TOLD_FROM:
        return ()
    limit = float(np.median(tops))
    return (
        f"{len(tops)} peaks of the angular rate are cut off at some {limit:.3g} rad/s "
        f"({np.degrees(limit):.0f} deg/s), the gyroscope's range: they are put back as their "
        "flanks say; a wider range would know",
    )


def _highest(values: np.ndarray, ahead: int) -> np.ndarray:
    """(n,) the highest so far, as it is known `ahead` samples later."""
    so_far = np.maximum.accumulate(values)
    return np.concatenate([so_far[ahead:], np.full(min(ahead, len(values)), so_far[-1])])


def _lacking(rate: np.ndarray, begin: int, end: int, slope_len: int) -> np.ndarray:
    """(end - begin,) by how much the cubic is above the top."""
    first, last = begin - 1, end
    wide = last - first
    rises = max(0.0, rate[first] - rate[first - slope_len]) / slope_len * wide
    falls = max(0.0, rate[last] - rate[last + slope_len]) / slope_len * wide
    t = np.arange(1, wide) / wide
    cubic = (
        rate[first]
        + (3 - 2 * t) * t**2 * (rate[last] - rate[first])
        + t * (1 - t) * ((1 - t) * rises + t * falls)
    )
    return np.maximum(cubic - rate[begin:end], 0.0)
