# SPDX-License-Identifier: MIT
"""Twin of temperature.h in Python's unbounded integers, straight from its contract."""

from __future__ import annotations

from collections.abc import Mapping

from terazi.models.exact import COUNTER_MAX, COUNTS_MAX, COUNTS_MIN, rounded_shift

LOWEST_CENTI, HIGHEST_CENTI = -4000, 8500
STEP_MAX_CENTI = 400
SMOOTHING_SHIFT = 4
SPAN_MAX_PPM_PER_K_Q4 = 4000


def scaled(value: int, share_q32: int) -> int:
    """value * share_q32 / 2^32, rounded half away from zero."""
    size = (abs(value) * share_q32 + (1 << 31)) >> 32
    return -size if value < 0 else size


class Temperature:
    """temperature.h; `config` has the fields of temperature_config_t and may be changed."""

    def __init__(self, config: Mapping[str, int]) -> None:
        self.config = config
        self.smoothed_q1: int | None = None
        self.refused = self.clipped = 0

    def update(self, measured_centi: int) -> None:
        """One reading."""
        if not LOWEST_CENTI <= measured_centi <= HIGHEST_CENTI:
            self.refused = min(self.refused + 1, COUNTER_MAX)
        elif self.smoothed_q1 is None:
            self.smoothed_q1 = 2 * measured_centi
        else:
            limit_q1 = 2 * STEP_MAX_CENTI
            off_q1 = 2 * measured_centi - self.smoothed_q1
            off_q1 = max(-limit_q1, min(limit_q1, off_q1))
            self.smoothed_q1 += rounded_shift(off_q1, SMOOTHING_SHIFT)

    @property
    def centi(self) -> int | None:
        """The temperature that corrections are made for."""
        return None if self.smoothed_q1 is None else rounded_shift(self.smoothed_q1, 1)

    def correct(self, raw_counts: int) -> int:
        """One count, at the reference temperature."""
        if self.smoothed_q1 is None or not self.config["on"]:
            return raw_counts
        above_centi = self.centi - self.config["reference_centi"]
        zero_q7 = scaled(self.config["zero_counts_per_k_q4"] * above_centi, 343597384)
        share_q32 = scaled(self.config["span_ppm_per_k_q4"] * above_centi * 4, 2882303762)
        above_origin = raw_counts - self.config["origin_counts"]
        drift_q7 = zero_q7 + scaled(above_origin * share_q32, 1 << 7)
        corrected = raw_counts - rounded_shift(drift_q7, 7)
        limited = min(max(corrected, COUNTS_MIN), COUNTS_MAX)
        if limited != corrected:
            self.clipped = min(self.clipped + 1, COUNTER_MAX)
        return limited
