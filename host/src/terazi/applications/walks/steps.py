# SPDX-License-Identifier: MIT
"""Strides of a path: from stance to stance of the same foot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from terazi.applications.walks.navigator import Path
from terazi.applications.walks.windows import spans

STRIDE_M = 0.15  # less is a foot that shuffles where it stands
STANCE_S = 0.02


@dataclass(frozen=True)
class Strides:
    """at : (k + 1,) samples in the middle of the stances between which the k strides lie."""

    at: np.ndarray
    pos_w_m: np.ndarray  # (k + 1, 3)

    def __len__(self) -> int:
        return max(len(self.at) - 1, 0)

    @property
    def vectors_m(self) -> np.ndarray:
        """(k, 3)."""
        return np.diff(self.pos_w_m, axis=0)

    @property
    def length_m(self) -> float:
        """Way of the foot on the floor's plan."""
        return float(np.linalg.norm(self.vectors_m[:, :2], axis=1).sum())


def stances(still: np.ndarray, rate_hz: float) -> np.ndarray:
    """(m, 2) first sample and first no longer in it, of each stance that lasts."""
    found = spans(still)
    return found[found[:, 1] - found[:, 0] >= STANCE_S * rate_hz]


def find_strides(path: Path, rate_hz: float) -> Strides:
    """Stances one stride or more apart; of stances closer together, the first."""
    kept: list[int] = []
    for begin, end in stances(path.still, rate_hz):
        at = (begin + end - 1) // 2
        if not kept or np.linalg.norm(path.pos_w_m[at] - path.pos_w_m[kept[-1]]) >= STRIDE_M:
            kept.append(int(at))
    index = np.array(kept, dtype=np.int64)
    return Strides(index, path.pos_w_m[index])
