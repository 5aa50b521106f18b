# SPDX-License-Identifier: MIT
"""Float64 truth for mass.c."""

from __future__ import annotations

import numpy as np


def mass_mg(net_counts, span_ug_per_count):
    """Milligrams of counts above the tare.

    net_counts : (n,) float64.  span_ug_per_count : float.
    Returns (n,) float64 mg, not limited to 32 bits.

    The C is exact but for one rounding, so |C - model| <= 0.5 mg plus what float64 itself loses,
    as long as the mass is below 2^31 mg (2147 kg): shared_c/notes/mass.md.
    """
    return np.asarray(net_counts, dtype=np.float64) * span_ug_per_count / 1000.0
