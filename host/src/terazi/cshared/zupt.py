# SPDX-License-Identifier: MIT
"""zupt of shared_c for numpy and, step by step, for Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from terazi.cshared._cshared import ffi, lib
from terazi.cshared.imu import int16_vectors, pointer
from terazi.cshared.state import CState

ZUPT_DETECTORS = {
    name.removeprefix("ZUPT_").lower(): getattr(lib, name)
    for name in ("ZUPT_SHOE", "ZUPT_ARE", "ZUPT_MOVING_VARIANCE", "ZUPT_MAGNITUDE")
}
"""Names of zupt.toml -> numbers of zupt.h."""

ZUPT_RATES = {
    name.removeprefix("ZUPT_RATE_").lower(): getattr(lib, name)
    for name in dir(lib)
    if name.startswith("ZUPT_RATE_")
}
"""Rates of zupt.toml."""


class ZeroVelocity(CState):
    """What both detectors share: samples in, stillness out."""

    _functions: str  # what the names of the C's functions begin with

    def _call(self, function: str, *arguments):
        return getattr(lib, f"{self._functions}_{function}")(self._c, *arguments)

    @property
    def still(self) -> bool:
        """What the last update gave."""
        return self._c.still == lib.ZUPT_STILL

    @property
    def rejected(self) -> int:
        """Samples, or vectors, on a rail so far; stops at 65535."""
        return self._c.rejected

    def interrupt(self) -> None:
        """Samples were lost: not still until the detector has seen enough anew."""
        self._call("interrupt")

    def update(self, gyro_b_counts: Sequence[int], acc_b_counts: Sequence[int]) -> bool:
        """Take one sample; gives whether it stands still."""
        gyro, acc = (
            ffi.new("int16_t[3]", [int(e) for e in v]) for v in (gyro_b_counts, acc_b_counts)
        )
        return self._call("update", gyro, acc) == lib.ZUPT_STILL

    def block(self, gyro_b_counts, acc_b_counts) -> np.ndarray:
        """Take (n, 3) samples; gives (n,) bool after each."""
        gyro = int16_vectors(gyro_b_counts, "gyroscope values")
        acc = int16_vectors(acc_b_counts, "accelerometer values")
        if len(gyro) != len(acc):
            raise ValueError(f"{len(gyro)} gyroscope and {len(acc)} accelerometer values")
        flags = np.empty(len(gyro), dtype=np.uint8)
        self._call("blocks", pointer(gyro), pointer(acc), pointer(flags), len(gyro))
        return flags == lib.ZUPT_STILL


class Zupt(ZeroVelocity):
    """Zero velocity (zupt.h).

    config : name of a detector of zupt.toml, at `rate`, as the device has it; or fields of
        zupt_config_t, as terazi.design.zupt.config_at makes them for any rate and any limits.
    """

    _functions = "zupt"

    def __init__(self, config: str | Mapping, rate: str = "500hz"):
        self._c = ffi.new("zupt_t *")
        if isinstance(config, str):
            if config not in ZUPT_DETECTORS:
                raise ValueError(f"no detector {config!r}; there are {', '.join(ZUPT_DETECTORS)}")
            if rate not in ZUPT_RATES:
                raise ValueError(f"no rate {rate!r}; there are {', '.join(ZUPT_RATES)}")
            lib.zupt_choose(self._c, ZUPT_DETECTORS[config], ZUPT_RATES[rate])
            return
        try:
            fields = ffi.new("zupt_config_t *", dict(config))
        except OverflowError as error:
            raise ValueError(f"configuration of zupt: {error}") from None
        if not lib.zupt_is_lawful(fields):
            raise ValueError(f"configuration of zupt is beyond zupt.h: {dict(config)}")
        lib.zupt_init(self._c, fields)
