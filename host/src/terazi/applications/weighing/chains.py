# SPDX-License-Identifier: MIT
"""The filters that are compared: the chip's own, through cshared, and those of common libraries.

Each takes (n,) int32 counts and gives (n,) float64 counts; each starts as the chip does, primed
with its first sample.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from terazi.cshared import Fir, WeightKf, WeightKfAdaptive
from terazi.design.weight_kf import gain_schedule, quantise_q15

Chain = Callable[[np.ndarray], np.ndarray]
Gains = str | list[int]

ONE_Q7 = 128
SCHEDULE_LEN = 250


def constant_gains(process_var: float, noise_var: float) -> list[int]:
    """The Q15 schedule of a filter with constant Q and R that trusts its first sample like R."""
    return quantise_q15(
        gain_schedule(
            process_var=process_var,
            noise_var=noise_var,
            initial_var=noise_var,
            length=SCHEDULE_LEN,
        )
    )


def whole_counts(estimate_q7: np.ndarray) -> np.ndarray:
    """Estimates to whole counts, half up, as the FIR takes them."""
    return ((estimate_q7.astype(np.int64) + ONE_Q7 // 2) >> 7).astype(np.int32)


def kf(gains: Gains) -> Chain:
    return lambda counts: WeightKf(gains, int(counts[0])).block(counts) / ONE_Q7


def fir(counts: np.ndarray) -> np.ndarray:
    """The default FIR, whole counts."""
    return Fir(first_counts=int(counts[0])).block(counts)


def kf_then_fir(gains: Gains) -> Chain:
    def run(counts: np.ndarray) -> np.ndarray:
        estimate_q7 = WeightKf(gains, int(counts[0])).block(counts)
        return fir(whole_counts(estimate_q7)).astype(np.float64)

    return run


def fir_then_kf(gains: Gains) -> Chain:
    return lambda counts: kf(gains)(fir(counts))


def fir_then_adaptive(counts: np.ndarray) -> np.ndarray:
    smooth = fir(counts)
    return WeightKfAdaptive(first_counts=int(smooth[0])).block(smooth) / ONE_Q7


def _last(counts: np.ndarray, length: int) -> np.ndarray:
    """(n, length) windows that end at each sample; before the first one lies the first value."""
    padded = np.concatenate([np.full(length - 1, counts[0]), counts])
    return sliding_window_view(padded, length)


def mean_of(length: int) -> Chain:
    return lambda counts: _last(counts, length).mean(axis=1)


def median_of(length: int) -> Chain:
    return lambda counts: np.median(_last(counts, length), axis=1)


def exponential(share: float) -> Chain:
    """y += share (x - y), which is a constant-gain filter in float."""

    def run(counts: np.ndarray) -> np.ndarray:
        smooth = np.empty(counts.size)
        value = float(counts[0])
        for at, count in enumerate(counts.tolist()):
            value += share * (count - value)
            smooth[at] = value
        return smooth

    return run


# As the libraries that most sketches use have them: means of 10 and 16 readings, a median of 7,
# and a running average that believes each new reading by half.
COMMON: dict[str, Chain] = {
    "mean_of_10": mean_of(10),
    "mean_of_16": mean_of(16),
    "median_of_7": median_of(7),
    "exponential_0.5": exponential(0.5),
}
