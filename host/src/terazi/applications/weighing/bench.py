# SPDX-License-Identifier: MIT
"""A load cell, a converter and the chip's chain behind them: FIR, adaptive Kalman filter, scale.

Everything here is simulated, and seeded; what runs behind the converter is the chip's own code.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from terazi.cshared import Fir, Scale, ScaleFlag, WeightKfAdaptive
from terazi.design import scale as design

ONE_Q7 = design.ONE_COUNT_Q7
COUNTS_24_BITS = (-(1 << 23), (1 << 23) - 1)
US_PER_S = 1e6
REST_S = 5.0  # before anything happens, so that the Kalman filter has learnt the noise


@dataclass(frozen=True)
class Cell:
    """Counts of a load: a straight line from zero to Max that bows by `bow` of Max between."""

    max_g: float = 5000.0
    counts_per_g: float = 429.55  # 1 mV/V at gain 128: 2.328 mg a count
    bow: float = 0.0
    noise_counts: float = 38.7  # HX711 datasheet p. 3: 90 nV rms at 80 SPS

    def counts(self, load_g) -> np.ndarray:
        """(n,) float64 counts, without noise."""
        share = np.asarray(load_g, dtype=np.float64) / self.max_g
        return self.counts_per_g * self.max_g * (share + 4 * self.bow * share * (1 - share))

    def measure(self, load_g, random: np.random.Generator) -> np.ndarray:
        """(n,) int32: what the converter gives."""
        counts = self.counts(load_g)
        noisy = counts + self.noise_counts * random.standard_normal(counts.shape)
        return np.rint(np.clip(noisy, *COUNTS_24_BITS)).astype(np.int32)


@dataclass(frozen=True)
class Weighed:
    """What the chain gives after each sample."""

    t_s: np.ndarray
    truth_g: np.ndarray
    mass_g: np.ndarray  # by the curve alone
    net_g: np.ndarray
    shown: np.ndarray  # in 10^-decimals of the unit
    stable: np.ndarray  # bool
    estimate_q7: np.ndarray


def sample_times(rate_sps: float, duration_s: float, random: np.random.Generator) -> np.ndarray:
    """Times of conversions; where the first lies is chance, as it is for a load put on."""
    return (np.arange(round(duration_s * rate_sps)) + random.uniform()) / rate_sps


def weigh(
    cell: Cell,
    load_g: Callable[[np.ndarray], np.ndarray],
    t_s: np.ndarray,
    random: np.random.Generator,
    config: dict | None = None,
) -> Weighed:
    """A load over time, by the chip's chain in its default order.

    load_g : gram at given times.  config : fields of scale_config_t; None: the factory's.
    """
    truth_g = np.asarray(load_g(t_s), dtype=np.float64)
    raw = cell.measure(truth_g, random)
    smooth = Fir(first_counts=int(raw[0])).block(raw)
    estimate_q7 = WeightKfAdaptive(first_counts=int(smooth[0])).block(smooth)
    scale = Scale(config)
    times_us = np.rint(t_s * US_PER_S).astype(np.int64) % (1 << 32)
    flags, net_mg, shown = scale.block(estimate_q7, times_us, raw * ONE_Q7)
    return Weighed(
        t_s=t_s,
        truth_g=truth_g,
        mass_g=scale.masses(estimate_q7) / 1000.0,
        net_g=net_mg / 1000.0,
        shown=shown,
        stable=(flags & ScaleFlag.STABLE) != 0,
        estimate_q7=estimate_q7,
    )


def piecewise(times_s: Sequence[float], loads_g: Sequence[float]):
    """A load that is put on at once: loads_g[0] until times_s[0] and so on."""
    edges, loads = np.asarray(times_s), np.asarray(loads_g, dtype=np.float64)
    return lambda t_s: loads[np.searchsorted(edges, t_s, side="right")]
