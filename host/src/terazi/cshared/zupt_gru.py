# SPDX-License-Identifier: MIT
"""zupt_gru of shared_c for numpy and, step by step, for Python."""

from __future__ import annotations

from terazi.cshared._cshared import ffi, lib
from terazi.cshared.zupt import ZeroVelocity


class ZuptGru(ZeroVelocity):
    """The learnt detector of zero velocity (zupt_gru.h), whose weights are those of the device.

    sample_ms : 1 at 1 kHz, 2 at 500 Hz.
    """

    _functions = "zupt_gru"

    def __init__(self, sample_ms: int):
        if sample_ms not in (1, 2):
            raise ValueError(f"a sample every {sample_ms} ms; there are 1 and 2")
        self._c = ffi.new("zupt_gru_t *")
        lib.zupt_gru_init(self._c, sample_ms)

    @property
    def seen(self) -> list[int]:
        """Both inputs in octaves Q10, then eight states in Q13."""
        return list(self._c.seen)

    @property
    def best(self) -> list[int]:
        """Best scores of the newest blocks of steps, in sums (port_gru.h)."""
        return list(self._c.best)
