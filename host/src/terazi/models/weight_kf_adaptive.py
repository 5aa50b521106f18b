# SPDX-License-Identifier: MIT
"""Float64 truth for weight_kf_adaptive.c."""

from __future__ import annotations

import math

import numpy as np

from terazi.design import specs

COUNTS_MIN, COUNTS_MAX = -(1 << 23), (1 << 23) - 1
GAIN_STEPS = 1 << 16  # of the C's gain
SIGMA_OVER_MEAN_MAGNITUDE = 642 / 512  # sqrt(pi / 2), of a normal deviate; rounded as in the C


def _within(value: float, magnitude: float) -> float:
    return min(max(value, -magnitude), magnitude)


class _Rest:
    """The filter itself, one measurement at a time."""

    def __init__(self, variant, law, first):
        self.law = law
        self.gain_steps = GAIN_STEPS if variant.get("rounded_gain") else 0
        self.process_var = variant["process_var_q16"] / 65536
        self.bounds = (variant["noise_min_q8"] / 256, variant["noise_max_q8"] / 256)
        self.estimate = first
        self.noise = variant["noise_q8"] / 256
        self.var = self.noise**2
        self.before = (first, first)

    def outside(self, measured: float, sigmas: float) -> float:
        """How far to go to come within so many sigma of what the last three span."""
        span, margin = (measured, *self.before), sigmas * self.noise
        inside = min(max(self.estimate, min(span) - margin), max(span) + margin)
        return inside - self.estimate

    def update(self, measured: float, *, jumps: bool) -> None:
        """One update; `jumps`: with the innovation test."""
        law, noise = self.law, self.noise
        jump = self.outside(measured, law["jump_from_sigmas"]) if jumps else 0.0
        self.before = (measured, self.before[0])

        predicted = self.var + self.process_var
        total = predicted + noise**2
        opened = min(abs(jump) * noise / law["reopen_sigmas"], total)
        gain = max(opened, predicted) / total
        if self.gain_steps:
            gain = min(math.floor(gain * self.gain_steps), self.gain_steps - 1)
            gain /= self.gain_steps
        self.estimate += jump
        left = _within(measured - self.estimate, law["limit_sigmas"] * noise)
        self.estimate += gain * left
        if opened > predicted:
            self.var = gain * noise**2
        else:  # Joseph: of any gain, also a rounded one
            self.var = (1 - gain) ** 2 * predicted + gain**2 * noise**2
        cap = max(law["learn_cap_sigmas"] * noise - abs(jump), law["learn_from_sigmas"] * noise)
        self.learn(left, cap, law["learn_shift"])

    def learn(self, innovation: float, cap: float, shift: int) -> None:
        """Take an innovation's magnitude into the noise."""
        taught = SIGMA_OVER_MEAN_MAGNITUDE * min(abs(innovation), cap)
        low, high = self.bounds
        self.noise = min(max(self.noise + (taught - self.noise) * 2.0**-shift, low), high)


class _Pair:
    """The two models."""

    def __init__(self, variant, law, first):
        self.rest = _Rest(variant, law, first)
        self.law = law
        self.moving_estimate = first
        self.quiet, self.moving = 0, False

    @property
    def estimate(self) -> float:
        return self.moving_estimate if self.moving else self.rest.estimate

    def update(self, measured: float) -> None:
        innovation = measured - self.moving_estimate
        self.moving_estimate += innovation * 2.0 ** -self.law["moving_shift"]
        if self.moving:
            self._follow(innovation)
        elif self.rest.outside(measured, self.law["moving_from_sigmas"]):
            self.moving, self.quiet, self.moving_estimate = True, 0, measured
        else:
            self.rest.update(measured, jumps=False)

    def _follow(self, innovation: float) -> None:
        rest, law = self.rest, self.law
        noise = rest.noise
        is_quiet = abs(innovation) < law["moving_quiet_sigmas"] * noise
        self.quiet = self.quiet + 1 if is_quiet else 0
        if self.quiet == law["moving_quiet_samples"]:
            self.moving = False
            rest.before = (self.moving_estimate,) * 2
            apart = abs(self.moving_estimate - rest.estimate)
            if apart > law["same_load_sigmas"] * noise:
                rest.estimate, rest.var = self.moving_estimate, noise**2 / 2
        rest.learn(innovation, law["learn_cap_sigmas"] * noise, law["moving_learn_shift"])


def weight_kf_adaptive(
    measured_counts,
    *,
    variant="default",
    first_counts=None,
    pair=False,
    rounded_gain=True,
    learnt=None,
):
    """Float64 truth for ``weight_kf_adaptive_update`` over a run of measurements.

    measured_counts : (n,) numbers, uniform sampling. What is not a number is skipped: the
        estimate stands, as on the device where no conversion came.
    variant : name or index of weight_kf_adaptive.toml.
    first_counts : where the estimate starts; None: the first measurement.
    pair : ``weight_kf_adaptive_pair_update`` in its place.
    rounded_gain : K in whole 2^-16 as the C has it; False: the true one.
    learnt : (n,) float64 array to be filled with the noise after each measurement, counts rms.
    Returns (n,) float64 counts (the C gives them in Q7).

    The header's equations in real numbers, squares limited as there. The C rounds x to 1/128
    count, P and R to 1/4096 count^2 and K to Q16: shared_c/notes/weight_kf_adaptive.md.
    """
    measured = np.clip(np.asarray(measured_counts, dtype=np.float64), COUNTS_MIN, COUNTS_MAX)
    if measured.size == 0:
        return measured
    known = measured[~np.isnan(measured)]
    if first_counts is None:
        first_counts = known[0] if known.size else 0.0
    first = min(max(float(first_counts), COUNTS_MIN), COUNTS_MAX)
    law = specs.weight_kf_adaptive_law()
    config = {**specs.weight_kf_adaptive_config(variant), "rounded_gain": rounded_gain}
    kf = (_Pair if pair else _Rest)(config, law, first)
    rest = kf.rest if pair else kf
    estimates = np.empty_like(measured)
    for n, z in enumerate(measured.tolist()):
        if not math.isnan(z):
            kf.update(z) if pair else kf.update(z, jumps=True)
        estimates[n] = kf.estimate
        if learnt is not None:
            learnt[n] = rest.noise
    return estimates
