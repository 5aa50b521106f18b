# SPDX-License-Identifier: MIT
"""zupt_gru of shared_c for numpy and, step by step, for Python."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from terazi.cshared._cshared import ffi, lib
from terazi.cshared.imu import int16_vectors, pointer
from terazi.cshared.state import CState


class ZuptGru(CState):
    """The learnt detector of zero velocity (zupt_gru.h), whose weights are those of the device.

    sample_ms : 1 at 1 kHz, 2 at 500 Hz.
    """

    def __init__(self, sample_ms: int):
        if sample_ms not in (1, 2):
            raise ValueError(f"a sample every {sample_ms} ms; there are 1 and 2")
        self._c = ffi.new("zupt_gru_t *")
        lib.zupt_gru_init(self._c, sample_ms)

    def restore(self, state: bytes) -> None:
        """Continue where save() was called; its rate comes along."""
        if len(state) != ffi.sizeof(self._c[0]):
            raise ValueError(f"not the state of a {type(self).__name__}")
        ffi.buffer(self._c)[:] = state

    @property
    def still(self) -> bool:
        """What the last update gave."""
        return self._c.still == lib.ZUPT_STILL

    @property
    def rejected(self) -> int:
        """Vectors on a rail so far, stops at 65535."""
        return self._c.rejected

    @property
    def seen(self) -> list[int]:
        """Both inputs in octaves Q10, then eight states in Q13."""
        return list(self._c.seen)

    @property
    def best(self) -> list[int]:
        """Best scores of the newest blocks of steps, in sums (port_gru.h)."""
        return list(self._c.best)

    def interrupt(self) -> None:
        """Samples were lost: not still, and the network begins anew."""
        lib.zupt_gru_interrupt(self._c)

    def update(self, gyro_b_counts: Sequence[int], acc_b_counts: Sequence[int]) -> bool:
        """Take one sample; gives whether the foot stands still."""
        gyro, acc = (
            ffi.new("int16_t[3]", [int(e) for e in v]) for v in (gyro_b_counts, acc_b_counts)
        )
        return lib.zupt_gru_update(self._c, gyro, acc) == lib.ZUPT_STILL

    def block(self, gyro_b_counts, acc_b_counts) -> np.ndarray:
        """Take (n, 3) samples; gives (n,) bool after each."""
        gyro = int16_vectors(gyro_b_counts, "gyroscope values")
        acc = int16_vectors(acc_b_counts, "accelerometer values")
        if len(gyro) != len(acc):
            raise ValueError(f"{len(gyro)} gyroscope and {len(acc)} accelerometer values")
        flags = np.empty(len(gyro), dtype=np.uint8)
        lib.zupt_gru_blocks(self._c, pointer(gyro), pointer(acc), pointer(flags), len(gyro))
        return flags == lib.ZUPT_STILL
