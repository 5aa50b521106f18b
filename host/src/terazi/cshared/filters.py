# SPDX-License-Identifier: MIT
"""fir, weight_kf and mass of shared_c for numpy and, step by step, for Python."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

from terazi.cshared._cshared import ffi, lib


def _names(prefix: str) -> tuple[str, ...]:
    """Names of a generated index enumeration, in order of index."""
    found = [name for name in dir(lib) if name.startswith(prefix)]
    found.sort(key=lambda name: getattr(lib, name))
    return tuple(name.removeprefix(prefix).lower() for name in found)


FIR_DESIGNS = _names("FIR_DESIGN_")
"""Designs of fir.toml; HELLO.fir_design is an index into this."""

WEIGHT_KF_SCHEDULES = _names("WEIGHT_KF_SCHEDULE_")
"""Schedules of weight_kf.toml; HELLO.kf_schedule is an index into this."""


def _named(choice: str | int, names: tuple[str, ...], what: str) -> str:
    if isinstance(choice, str):
        if choice in names:
            return choice
    elif 0 <= choice < len(names):
        return names[choice]
    raise ValueError(f"no {what} {choice!r}; there are {', '.join(names)}")


def _int32(values, what: str) -> np.ndarray:
    """values as a contiguous int32 array, refused where that would change one."""
    array = np.asarray(values)
    if array.ndim != 1:
        raise ValueError(f"{what} must have one dimension, not {array.ndim}")
    if array.size and array.dtype.kind not in "iu":
        raise TypeError(f"{what} must be integers, not {array.dtype}")
    converted = np.ascontiguousarray(array, dtype=np.int32)
    if array.dtype != np.int32 and not np.array_equal(converted, array):
        raise ValueError(f"{what} do not fit in 32 bits")
    return converted


def _pointer(array: np.ndarray):
    return ffi.from_buffer("int32_t[]", array, require_writable=array.flags.writeable)


class Fir:
    """One FIR filter (fir.h).

    design : name or index of fir.toml, or all coefficients in Q15 (2 to 64, symmetric, sum 32768,
        magnitudes together below 65536), which then lie in memory as those from settings do.
    first_counts : the value that fills the window.
    by_heart : use the way of the default design, fir_update_default; the answers are the same.
    """

    def __init__(
        self,
        design: str | int | Sequence[int] = "lowpass32",
        first_counts: int = 0,
        *,
        by_heart: bool = False,
    ):
        self._update = lib.fir_update_default if by_heart else lib.fir_update
        if isinstance(design, str | int | np.integer):
            self._config = ffi.addressof(lib, f"fir_{_named(design, FIR_DESIGNS, 'FIR design')}")
        else:
            self._config = self._own_config([int(each) for each in design])
        self._c = ffi.new("fir_t *")
        lib.fir_init(self._c, self._config, first_counts)

    def _own_config(self, taps: list[int]):
        if not 2 <= len(taps) <= lib.FIR_TAPS_MAX or taps != taps[::-1]:
            raise ValueError(f"taps must be symmetric, 2 to {lib.FIR_TAPS_MAX} of them")
        half = taps[: (len(taps) + 1) // 2]
        if not all(-32768 <= tap <= 32767 for tap in half):
            raise ValueError("taps must fit in Q15")
        self._half_q15 = ffi.new("int16_t[]", half)  # config points to it
        config = ffi.new("fir_config_t *")
        if not lib.fir_load(config, self._half_q15, len(taps)):
            raise ValueError("taps must sum to 32768 and their magnitudes to less than 65536")
        return config

    @property
    def taps(self) -> int:
        """Length of the impulse response in samples."""
        return self._config.taps

    @property
    def delay_samples(self) -> float:
        """Group delay: what the results are late by, at every frequency."""
        return lib.fir_delay_half_samples(self._config) / 2

    @property
    def clipped(self) -> int:
        """Samples and results clamped so far, stops at 65535."""
        return self._c.clipped

    def update(self, sample_counts: int) -> int:
        """Take one sample, give one result, both in counts."""
        return self._update(self._c, sample_counts)

    def block(self, samples_counts) -> np.ndarray:
        """Take (n,) samples, give (n,) int32 results."""
        samples = _int32(samples_counts, "samples")
        results = np.empty(samples.size, dtype=np.int32)
        lib.blocks_fir(self._c, _pointer(samples), _pointer(results), samples.size)
        return results

    def save(self) -> bytes:
        """State, for restore() on a filter of the same length."""
        window = bytes(ffi.buffer(self._c.window))[: lib.FIR_SAMPLE_BYTES * self.taps]
        return window + struct.pack("<BH", self._c.next, self._c.clipped)

    def restore(self, state: bytes) -> None:
        """Continue where save() was called."""
        size = lib.FIR_SAMPLE_BYTES * self.taps
        window, rest = state[:-3], state[-3:]
        if len(state) != size + 3 or rest[0] >= size or rest[0] % lib.FIR_SAMPLE_BYTES:
            raise ValueError(f"not the state of a FIR filter of {self.taps} taps")
        whole = ffi.buffer(self._c.window)
        for at in range(0, len(whole) - size + 1, size)[:2]:  # the second copy, where it has room
            whole[at : at + size] = window
        self._c.next, self._c.clipped = struct.unpack("<BH", rest)

    def copy(self, *, by_heart: bool = False) -> Fir:
        """Another filter in the same state."""
        twin = object.__new__(Fir)
        twin.__dict__.update(self.__dict__)  # configuration is constant: shared
        twin._update = lib.fir_update_default if by_heart else lib.fir_update
        twin._c = ffi.new("fir_t *", self._c[0])
        return twin


class WeightKf:
    """One scalar Kalman filter (weight_kf.h).

    schedule : name or index of weight_kf.toml, or gains in Q15, each 1..32768, 1 to 255 of them.
    first_counts : where the estimate starts.
    """

    def __init__(self, schedule: str | int | Sequence[int] = "default", first_counts: int = 0):
        if isinstance(schedule, str | int | np.integer):
            name = _named(schedule, WEIGHT_KF_SCHEDULES, "gain schedule")
            self._config = ffi.addressof(lib, f"weight_kf_{name}")
        else:
            self._config = self._own_config([int(each) for each in schedule])
        self._c = ffi.new("weight_kf_t *")
        lib.weight_kf_init(self._c, self._config, first_counts)

    def _own_config(self, gains: list[int]):
        if not 1 <= len(gains) <= 255 or not all(1 <= gain <= 32768 for gain in gains):
            raise ValueError("1 to 255 gains of 1..32768 are needed")
        self._gain_q15 = ffi.new("uint16_t[]", gains)  # config points to it
        return ffi.new("weight_kf_config_t *", {"gain_q15": self._gain_q15, "gain_len": len(gains)})

    @property
    def clipped(self) -> int:
        """Measurements clamped so far, stops at 65535."""
        return self._c.clipped

    @property
    def estimate_counts_q7(self) -> int:
        """The present estimate."""
        return self._c.estimate_counts_q7

    def update(self, measured_counts: int) -> int:
        """Take one measurement in counts, give the new estimate in counts Q7."""
        return lib.weight_kf_update(self._c, measured_counts)

    def block(self, measured_counts) -> np.ndarray:
        """Take (n,) measurements, give (n,) int32 estimates in Q7."""
        measured = _int32(measured_counts, "measurements")
        estimates = np.empty(measured.size, dtype=np.int32)
        lib.blocks_weight_kf(self._c, _pointer(measured), _pointer(estimates), measured.size)
        return estimates

    def save(self) -> bytes:
        """State, for restore() on a filter of the same schedule."""
        return struct.pack("<iBH", self._c.estimate_counts_q7, self._c.step, self._c.clipped)

    def restore(self, state: bytes) -> None:
        """Continue where save() was called."""
        if len(state) != 7 or state[4] >= self._config.gain_len:
            raise ValueError("not the state of a Kalman filter of this schedule")
        self._c.estimate_counts_q7, self._c.step, self._c.clipped = struct.unpack("<iBH", state)

    def copy(self) -> WeightKf:
        """Another filter in the same state."""
        twin = object.__new__(WeightKf)
        twin.__dict__.update(self.__dict__)  # configuration is constant: shared
        twin._c = ffi.new("weight_kf_t *", self._c[0])
        return twin


def fir_block(samples, design: str | int | Sequence[int] = "lowpass32", first_counts=None):
    """FIR over (n,) samples in counts; gives (n,) int32.

    first_counts : primes the filter; None: the first sample does, as on the device.
    """
    samples = _int32(samples, "samples")
    if first_counts is None:
        first_counts = int(samples[0]) if samples.size else 0
    return Fir(design, first_counts).block(samples)


def weight_kf_block(measured, schedule: str | int | Sequence[int] = "default", first_counts=None):
    """Kalman filter over (n,) measurements in counts; gives (n,) int32 in counts Q7.

    first_counts : start of the estimate; None: the first measurement, as on the device.
    """
    measured = _int32(measured, "measurements")
    if first_counts is None:
        first_counts = int(measured[0]) if measured.size else 0
    return WeightKf(schedule, first_counts).block(measured)


def mass_mg_block(kf_q7, tare_q7: int, span_ug_per_count_q16: int) -> np.ndarray:
    """Milligrams, (n,) int32, of (n,) estimates in counts Q7 (mass.h).

    tare_q7 : the estimate that is zero load. All estimates lie within +-2^30, so that a
    difference fits in 32 bits.
    """
    kf_q7 = _int32(kf_q7, "estimates")
    largest = max(abs(int(kf_q7.max(initial=0))), abs(int(kf_q7.min(initial=0))), abs(tare_q7))
    if largest > 1 << 30:
        raise ValueError("estimates and tare must lie within +-2^30")
    mass_mg = np.empty(kf_q7.size, dtype=np.int32)
    lib.blocks_mass(_pointer(kf_q7), tare_q7, span_ug_per_count_q16, _pointer(mass_mg), kf_q7.size)
    return mass_mg
