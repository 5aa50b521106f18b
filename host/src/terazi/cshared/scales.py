# SPDX-License-Identifier: MIT
"""scale of shared_c for numpy and, step by step, for Python."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum, IntFlag

import numpy as np

from terazi.cshared._cshared import ffi, lib
from terazi.cshared.imu import pointer
from terazi.cshared.state import CState

_STATUS_WORDS = ["OK", "BAD_", "NOT_", "TOO_", "OUT_", "UNKNOWN"]


def _enumerators(prefixes: list[str]) -> dict[str, int]:
    names = (name.removeprefix("SCALE_") for name in dir(lib) if name.startswith("SCALE_"))
    return {
        name: getattr(lib, f"SCALE_{name}") for name in names if name.startswith(tuple(prefixes))
    }


ScaleStatus = IntEnum("ScaleStatus", _enumerators(_STATUS_WORDS))
ScaleFlag = IntFlag(
    "ScaleFlag",
    _enumerators(["STABLE", "AT_ZERO", "OVER", "UNDER", "STEPPED", "ZEROED", "TARED", "FROZEN"]),
)
ScaleShow = IntEnum(
    "ScaleShow", {k.removeprefix("SHOW_"): v for k, v in _enumerators(["SHOW_"]).items()}
)
SCALE_UNITS = tuple(
    sorted(
        (
            name.removeprefix("SCALE_UNIT_")
            for name in dir(lib)
            if name.startswith("SCALE_UNIT_") and name[11:] not in ("COUNT", "ENTRIES")
        ),
        key=lambda name: getattr(lib, f"SCALE_UNIT_{name}"),
    )
)
"""Units of scale.toml, in capitals, by index."""


class ScaleRefusedError(ValueError):
    """scale.h refused a configuration or a command; `status` says why."""

    def __init__(self, what: str, status: int) -> None:
        self.status = ScaleStatus(status)
        super().__init__(f"{what}: {self.status.name.lower().replace('_', ' ')}")


def whole(values, dtype, what: str) -> np.ndarray:
    """values as a contiguous array of dtype, refused where that would change one."""
    array = np.asarray(values)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise TypeError(f"{what} must be a row of integers, not {array.dtype}, {array.shape}")
    converted = np.ascontiguousarray(array, dtype=dtype)
    if not np.array_equal(converted, array):
        raise ValueError(f"{what} do not fit in {np.dtype(dtype).name}")
    return converted


class Scale(CState):
    """A scale (scale.h).

    config : fields of scale_config_t, as terazi.design.scale.config makes them; None: the nominal
        cell's. Refused by ScaleRefusedError, as commands are.
    """

    def __init__(self, config: Mapping | None = None):
        if config is None:
            self._config = ffi.addressof(lib, "scale_default")
        else:
            try:
                self._config = ffi.new("scale_config_t *", dict(config))
            except OverflowError as error:
                raise ValueError(f"configuration of the scale: {error}") from None
        self._c = ffi.new("scale_t *")
        self._accept("configuration", lib.scale_init(self._c, self._config))

    @staticmethod
    def _accept(what: str, status: int) -> None:
        if status != lib.SCALE_OK:
            raise ScaleRefusedError(what, status)

    def __getattr__(self, field: str):
        """Fields of scale_t: net_mg, load_mg, steps, step_us ..."""
        if field.startswith("_"):
            raise AttributeError(field)
        return getattr(self._c, field)

    @property
    def pieces(self) -> int:
        return lib.scale_pieces(self._c)

    @property
    def shown(self) -> int:
        """In 10^-decimals of the unit."""
        return lib.scale_shown(self._c)

    def mass(self, counts_q7: int) -> int:
        """Of any counts, in mg, by the calibration alone."""
        return lib.scale_mass(self._c, counts_q7)

    def masses(self, counts_q7) -> np.ndarray:
        """(n,) masses in mg of (n,) counts, by the calibration alone."""
        counts = whole(counts_q7, np.int32, "counts")
        masses_mg = np.empty(len(counts), dtype=np.int32)
        lib.scale_blocks_mass(self._c, pointer(counts), pointer(masses_mg), len(counts))
        return masses_mg

    def update(self, counts_q7: int, device_us: int, raw_q7: int | None = None) -> ScaleFlag:
        """Take one estimate; raw_q7: what was measured with it, before any filter."""
        raw = counts_q7 if raw_q7 is None else raw_q7
        return ScaleFlag(lib.scale_update(self._c, counts_q7, raw, device_us))

    @property
    def load_mg(self) -> int:
        """Of the last sample, above zero."""
        return self.mass_mg - self.zero_mg

    def block(self, counts_q7, device_us, raw_q7=None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Take (n,) estimates with their times; gives flags, net masses in mg, what is shown.

        raw_q7 : (n,) measurements before any filter; None: nothing is ahead of the estimates.
        """
        counts = whole(counts_q7, np.int32, "counts")
        raw = ffi.NULL if raw_q7 is None else pointer(whole(raw_q7, np.int32, "measurements"))
        if raw_q7 is not None and len(raw_q7) != len(counts):
            raise ValueError(f"{len(counts)} counts and {len(raw_q7)} measurements")
        times = whole(device_us, np.uint32, "times")
        if len(counts) != len(times):
            raise ValueError(f"{len(counts)} counts and {len(times)} times")
        flags = np.empty(len(counts), dtype=np.uint8)
        net_mg, shown = (np.empty(len(counts), dtype=np.int32) for _ in range(2))
        arrays = (pointer(array) for array in (counts, times, flags, net_mg, shown))
        lib.scale_blocks_update(self._c, raw, *arrays, len(counts))
        return flags, net_mg, shown

    def resume(self, zero_mg: int, tare_mg: int, firm: bool) -> None:
        """Begin with a zero and a tare of before; firm: no zero at the first stable mass."""
        lib.scale_resume(self._c, zero_mg, tare_mg, firm)

    def interrupt(self) -> None:
        """Samples were lost."""
        lib.scale_interrupt(self._c)

    def zero(self) -> None:
        self._accept("zero", lib.scale_zero(self._c))

    def tare(self) -> None:
        self._accept("tare", lib.scale_tare(self._c))

    def tare_clear(self) -> None:
        lib.scale_tare_clear(self._c)

    def show(self, what: int) -> None:
        """One of ScaleShow."""
        self._accept("show", lib.scale_show(self._c, what))

    def count_out(self, pieces: int) -> None:
        """What lies there net is so many pieces."""
        self._accept("pieces", lib.scale_count_out(self._c, pieces))
