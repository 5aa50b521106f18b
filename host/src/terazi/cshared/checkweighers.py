# SPDX-License-Identifier: MIT
"""checkweigher of shared_c for numpy and, step by step, for Python."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum

import numpy as np

from terazi.cshared._cshared import ffi, lib
from terazi.cshared.imu import pointer
from terazi.cshared.scales import whole
from terazi.cshared.state import CState

CheckweigherEvent = IntEnum(
    "CheckweigherEvent",
    {
        name: getattr(lib, f"CHECKWEIGHER_{name}")
        for name in ("EMPTY", "LOADED", "VERDICT", "UNWEIGHED")
    },
)

CLASSES_MAX: int = lib.CHECKWEIGHER_CLASSES_MAX
SAMPLES_MIN: int = lib.CHECKWEIGHER_SAMPLES_MIN
SAMPLES_MAX: int = lib.CHECKWEIGHER_SAMPLES_MAX


class Checkweigher(CState):
    """Weighs, judges and counts products (checkweigher.h).

    config : fields of checkweigher_config_t.
    """

    def __init__(self, config: Mapping):
        try:
            self._config = ffi.new("checkweigher_config_t *", dict(config))
        except OverflowError as error:
            raise ValueError(f"configuration of the checkweigher: {error}") from None
        if not (
            1 <= self._config.classes <= CLASSES_MAX
            and SAMPLES_MIN <= self._config.samples_min <= SAMPLES_MAX
        ):
            raise ValueError(f"configuration is beyond checkweigher.h: {dict(config)}")
        self._c = ffi.new("checkweigher_t *")
        if not lib.checkweigher_init(self._c, self._config):
            raise ValueError(f"configuration is beyond checkweigher.h: {dict(config)}")

    def __getattr__(self, field: str):
        """Fields of checkweigher_t: mass_mg, class_at, unweighed, entered_us ..."""
        if field.startswith("_"):
            raise AttributeError(field)
        return getattr(self._c, field)

    @property
    def per_minute_q8(self) -> int:
        return lib.checkweigher_per_minute_q8(self._c)

    def update(self, mass_mg: int, device_us: int) -> CheckweigherEvent:
        """Take one mass."""
        return CheckweigherEvent(lib.checkweigher_update(self._c, mass_mg, device_us))

    def interrupt(self) -> None:
        """What lies on the platform cannot be weighed any more."""
        lib.checkweigher_interrupt(self._c)

    def block(self, mass_mg, device_us) -> tuple[np.ndarray, np.ndarray]:
        """Take (n,) masses with their times; gives events, and the last weight after each."""
        masses = whole(mass_mg, np.int32, "masses")
        times = whole(device_us, np.uint32, "times")
        if len(masses) != len(times):
            raise ValueError(f"{len(masses)} masses and {len(times)} times")
        events, weighed_mg = np.empty(len(masses), np.uint8), np.empty(len(masses), np.int32)
        arrays = (pointer(array) for array in (masses, times, events, weighed_mg))
        lib.scale_blocks_checkweigher(self._c, *arrays, len(masses))
        return events, weighed_mg
