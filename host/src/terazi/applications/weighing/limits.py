# SPDX-License-Identifier: MIT
"""What a scale of class III may err by: OIML R76, as in UK SI 1995/1907."""

from __future__ import annotations

import numpy as np

IN_SERVICE = 2.0  # the limits of verification are doubled in service


def permitted_error_e(load_e) -> np.ndarray:
    """Greatest permitted error in e at verification, of loads in e: 0.5 to 500, 1 to 2000, 1.5."""
    load_e = np.abs(np.asarray(load_e, dtype=np.float64))
    return np.where(load_e <= 500, 0.5, np.where(load_e <= 2000, 1.0, 1.5))
