# SPDX-License-Identifier: MIT
"""The seeded records that weighing filters are scored on.

After the weighing thesis's Table 5 (relative error of a Kalman filter alone, before and behind a
FIR), whose record is not published: loads that change in steps, white noise and the hum of a belt.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Experiment:
    """All that the records depend on. Loads in gram; counts are what the converter would give."""

    seed: int = 2016
    rate_hz: float = 80.0
    counts_per_g: float = 429.55  # 5 kg cell, 1 mV/V, gain 128: 2.328 mg a count
    loads_g: tuple[float, ...] = (500.0, 200.0, 800.0, 300.0, 600.0)
    dwell_s: float = 60.0
    white_noise_g: float = 2.0  # rms
    hum_g: float = 200.0  # amplitude
    hum_hz: float = 13.7
    drift_g: float = 10.0  # sqrt(Q) of the constant filters, a sample: loads change by hand
    converter_noise_counts: float = 38.7  # 90 nV rms at 80 SPS, HX711 datasheet p. 3
    step_g: float = 500.0  # of the settling time
    settled_share: float = 1e-3  # of the step: the band within which a filter has settled
    steps: int = 16  # settling times are the median of so many
    rest_s: float = 400.0  # of the noise at rest; the first sixth is for settling

    def samples(self, duration_s: float) -> int:
        return round(duration_s * self.rate_hz)

    def noisy_loads(self) -> tuple[np.ndarray, np.ndarray]:
        """The record of the relative error: (n,) int32 measured and (n,) true counts."""
        random = np.random.default_rng(self.seed)
        each = self.samples(self.dwell_s)
        true_g = np.repeat(np.asarray(self.loads_g), each)
        t_s = np.arange(true_g.size) / self.rate_hz
        hum_g = self.hum_g * np.sin(2 * np.pi * self.hum_hz * t_s + 1.0)
        white_g = self.white_noise_g * random.standard_normal(true_g.size)
        measured = np.rint((true_g + hum_g + white_g) * self.counts_per_g)
        return measured.astype(np.int32), true_g * self.counts_per_g

    def step_record(self, index: int) -> tuple[np.ndarray, int, float]:
        """A step in converter noise: (n,) int32 counts, sample of the step, level behind it."""
        random = np.random.default_rng((self.seed, index))
        before, behind = self.samples(60.0), self.samples(60.0)
        level = self.step_g * self.counts_per_g
        true = np.repeat([0.0, level], [before, behind])
        noise = self.converter_noise_counts * random.standard_normal(true.size)
        return np.rint(true + noise).astype(np.int32), before, level

    def rest_record(self) -> np.ndarray:
        """A load that rests, in converter noise: (n,) int32 counts around 0."""
        random = np.random.default_rng((self.seed, 1_000_000))
        noise = self.converter_noise_counts * random.standard_normal(self.samples(self.rest_s))
        return np.rint(noise).astype(np.int32)
