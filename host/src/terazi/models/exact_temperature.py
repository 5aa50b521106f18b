# SPDX-License-Identifier: MIT
"""Twin of temperature.h in Python's unbounded integers, straight from its contract."""

from __future__ import annotations

from collections.abc import Mapping

from terazi.models.exact import COUNTER_MAX, COUNTS_MAX, COUNTS_MIN, rounded_shift

LOWEST_CENTI, HIGHEST_CENTI = -4000, 8500
STEP_MAX_CENTI = 400
SMOOTHING_SHIFT = 4
SPAN_MAX_PPM_PER_K_Q4 = 4000


class Temperature:
    """temperature.h; `config` has the fields of temperature_config_t and may be changed."""

    def __init__(self, config: Mapping[str, int]) -> None:
        self.config = config
        self.smoothed_q8: int | None = None
        self.refused = self.clipped = 0

    def update(self, measured_centi: int) -> None:
        """One reading."""
        if not LOWEST_CENTI <= measured_centi <= HIGHEST_CENTI:
            self.refused = min(self.refused + 1, COUNTER_MAX)
        elif self.smoothed_q8 is None:
            self.smoothed_q8 = measured_centi << 8
        else:
            limit_q8 = STEP_MAX_CENTI << 8
            off_q8 = (measured_centi << 8) - self.smoothed_q8
            off_q8 = max(-limit_q8, min(limit_q8, off_q8))
            self.smoothed_q8 += rounded_shift(off_q8, SMOOTHING_SHIFT)

    @property
    def centi(self) -> int | None:
        """The temperature that corrections are made for."""
        return None if self.smoothed_q8 is None else rounded_shift(self.smoothed_q8, 8)

    def correct(self, raw_counts: int) -> int:
        """One count, at the reference temperature."""
        if self.smoothed_q8 is None or not self.config["on"]:
            return raw_counts
        above_q8 = rounded_shift((self.centi - self.config["reference_centi"]) * 4 * 20971, 15)
        zero_q5 = rounded_shift(self.config["zero_counts_per_k_q4"] * above_q8, 7)
        share_q31 = rounded_shift(self.config["span_ppm_per_k_q4"] * above_q8 * 17180, 15)
        share_q20 = rounded_shift(share_q31, 11)
        above_origin = raw_counts - self.config["origin_counts"]
        if share_q20 < 0:
            share_q20, above_origin = -share_q20, -above_origin
        drift_q5 = zero_q5 + rounded_shift(above_origin * share_q20, 15)
        corrected = raw_counts - rounded_shift(drift_q5, 5)
        limited = min(max(corrected, COUNTS_MIN), COUNTS_MAX)
        if limited != corrected:
            self.clipped = min(self.clipped + 1, COUNTER_MAX)
        return limited
