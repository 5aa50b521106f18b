# SPDX-License-Identifier: MIT
"""weight_kf_adaptive of shared_c for numpy and, step by step, for Python."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from terazi.cshared._cshared import ffi, lib
from terazi.cshared.filters import _int32, _named, _names, _pointer
from terazi.cshared.state import CState

WEIGHT_KF_ADAPTIVE_VARIANTS = _names("WEIGHT_KF_ADAPTIVE_VARIANT_")
"""Variants of weight_kf_adaptive.toml, in order of index."""

NOISE_MIN_Q8, NOISE_MAX_Q8 = 1 << 8, (1 << 15) - 1


class _Adaptive(CState):
    """What both share. variant : name or index of weight_kf_adaptive.toml, or the fields of
    weight_kf_adaptive_config_t. first_counts : where the estimate starts."""

    _TYPE, _INIT, _UPDATE, _BLOCK = "", None, None, None

    def __init__(self, variant: str | int | Mapping[str, int] = "default", first_counts: int = 0):
        if isinstance(variant, Mapping):
            self._config = self._own_config(variant)
        else:
            name = _named(variant, WEIGHT_KF_ADAPTIVE_VARIANTS, "adaptive variant")
            self._config = ffi.addressof(lib, f"weight_kf_adaptive_{name}")
        self._c = ffi.new(f"{self._TYPE} *")
        self._INIT(self._c, self._config, first_counts)

    @staticmethod
    def _own_config(fields: Mapping[str, int]):
        low, first, high = (fields[name] for name in ("noise_min_q8", "noise_q8", "noise_max_q8"))
        if not NOISE_MIN_Q8 <= low <= first <= high <= NOISE_MAX_Q8:
            raise ValueError("noise must lie within its bounds, and these within 1 to 127 counts")
        return ffi.new("weight_kf_adaptive_config_t *", dict(fields))

    @property
    def clipped(self) -> int:
        """Measurements clamped so far, stops at 65535."""
        return self._configured.clipped

    @property
    def noise_counts(self) -> float:
        """The noise as learnt, counts rms."""
        return self._configured.noise_q16 / 65536

    @property
    def var_counts2(self) -> float:
        """The estimate's variance as the filter believes."""
        return self._configured.var_q16 / 65536

    def update(self, measured_counts: int) -> int:
        """Take one measurement in counts, give the new estimate in counts Q7."""
        return self._UPDATE(self._c, measured_counts)

    def block(self, measured_counts, noise_counts: np.ndarray | None = None) -> np.ndarray:
        """Take (n,) measurements, give (n,) int32 estimates in Q7.

        noise_counts : (n,) float64, to be filled with the noise as learnt after each.
        """
        measured = _int32(measured_counts, "measurements")
        estimates = np.empty(measured.size, dtype=np.int32)
        noise_q16 = np.empty(measured.size, dtype=np.uint32)
        noise = ffi.from_buffer("uint32_t[]", noise_q16, require_writable=True)
        self._BLOCK(self._c, _pointer(measured), _pointer(estimates), noise, measured.size)
        if noise_counts is not None:
            noise_counts[:] = noise_q16 / 65536
        return estimates


class WeightKfAdaptive(_Adaptive):
    """One Kalman filter that learns the noise and reopens on a step (weight_kf_adaptive.h)."""

    _TYPE = "weight_kf_adaptive_t"
    _INIT = staticmethod(lib.weight_kf_adaptive_init)
    _UPDATE = staticmethod(lib.weight_kf_adaptive_update)
    _BLOCK = staticmethod(lib.adaptive_blocks_kf)

    @property
    def estimate_counts_q7(self) -> int:
        """The present estimate."""
        return self._c.estimate_counts_q7


class WeightKfPair(_Adaptive):
    """Two models, at rest and moving (weight_kf_adaptive.h)."""

    _TYPE = "weight_kf_adaptive_pair_t"
    _INIT = staticmethod(lib.weight_kf_adaptive_pair_init)
    _UPDATE = staticmethod(lib.weight_kf_adaptive_pair_update)
    _BLOCK = staticmethod(lib.adaptive_blocks_pair)

    @property
    def _configured(self):
        return self._c.rest

    @property
    def is_moving(self) -> bool:
        """Whether the moving model has the say."""
        return self._c.moving

    @property
    def estimate_counts_q7(self) -> int:
        """The present estimate of the model that has the say."""
        return self._c.moving_counts_q7 if self._c.moving else self._c.rest.estimate_counts_q7


def weight_kf_adaptive_block(
    measured, variant: str | int | Mapping[str, int] = "default", first_counts=None, *, pair=False
):
    """Adaptive Kalman filter over (n,) measurements in counts; gives (n,) int32 in counts Q7.

    first_counts : start of the estimate; None: the first measurement, as on the device.
    pair : the two models.
    """
    measured = _int32(measured, "measurements")
    if first_counts is None:
        first_counts = int(measured[0]) if measured.size else 0
    return (WeightKfPair if pair else WeightKfAdaptive)(variant, first_counts).block(measured)
