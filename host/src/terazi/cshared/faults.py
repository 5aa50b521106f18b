# SPDX-License-Identifier: MIT
"""faults of shared_c, step by step, and the device's chain from events to a weight over arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum, IntFlag

import numpy as np

from terazi.cshared._cshared import ffi, lib
from terazi.cshared.imu import pointer
from terazi.cshared.scales import Scale, ScaleFlag, whole
from terazi.cshared.state import CState

_KINDS = ("EVENT_", "CHANGED", "SPOILT", "RESTART")
_NAMES = [name.removeprefix("FAULTS_") for name in dir(lib) if name.startswith("FAULTS_")]
_BITS = ("CABLE_OUT", "DOUT_STUCK", "AT_RAIL", "RATE", "FRAMES_LOST", "NOISE")

Fault = IntFlag("Fault", {name: getattr(lib, f"FAULTS_{name}") for name in _BITS})
FaultsAnswer = IntFlag(
    "FaultsAnswer", {name: getattr(lib, f"FAULTS_{name}") for name in _KINDS[1:]}
)
FaultsEvent = IntEnum(
    "FaultsEvent",
    {
        name.removeprefix("EVENT_"): getattr(lib, f"FAULTS_{name}")
        for name in _NAMES
        if name.startswith("EVENT_")
    },
)


class Faults(CState):
    """Which faults hold (faults.h)."""

    def __init__(self, noise_counts: int | None = None) -> None:
        """noise_counts : rms of white noise that is a fault; None: as faults.toml has it."""
        self._c = ffi.new("faults_t *")
        lib.faults_init(self._c)
        if noise_counts is not None:
            lib.faults_limit_noise(self._c, noise_counts)

    @property
    def held(self) -> Fault:
        """Now."""
        return Fault(self._c.held)

    @property
    def seen(self) -> Fault:
        """Since the start."""
        return Fault(self._c.seen)

    @property
    def noisy(self) -> int:
        return self._c.noisy

    def update(self, event: int, counts: int = 0) -> FaultsAnswer:
        """Take one event."""
        return FaultsAnswer(lib.faults_update(self._c, event, counts))

    def pause(self) -> None:
        """A gap on purpose follows."""
        lib.faults_pause(self._c)


@dataclass(frozen=True)
class Weighed:
    """After each event: faults held, flags of the scale, the mass by the curve alone."""

    held: np.ndarray
    flags: np.ndarray
    mass_mg: np.ndarray

    @property
    def stable(self) -> np.ndarray:
        """(n,) bool: flagged stable."""
        return (self.flags & ScaleFlag.STABLE) != 0


def weigh_events(
    events,
    counts,
    device_us,
    config: Mapping | None = None,
    *,
    noise_counts: int | None = None,
    watched: bool = True,
) -> Weighed:
    """fir, weight_kf_adaptive, scale, kept from what faults finds, as the firmware does it.

    events, counts, device_us : (n,) integers: FaultsEvent, and what came with it.
    config : of the scale, as Scale takes it.
    noise_counts : as Faults takes it.
    watched : False: nothing that faults finds is heeded, to see what it is good for.
    """
    happened = whole(events, np.uint8, "events")
    raw, times = whole(counts, np.int32, "counts"), whole(device_us, np.uint32, "times")
    if not len(happened) == len(raw) == len(times):
        raise ValueError(f"{len(happened)} events, {len(raw)} counts and {len(times)} times")
    scale, chain = Scale(config), ffi.new("faults_blocks_t *")
    lib.faults_blocks_init(chain, scale._c)
    chain.watched = watched
    if noise_counts is not None:
        lib.faults_limit_noise(ffi.addressof(chain, "faults"), noise_counts)
    held, flags = (np.empty(len(raw), np.uint8) for _ in range(2))
    mass_mg = np.empty(len(raw), np.int32)
    arrays = (pointer(array) for array in (happened, raw, times, held, flags, mass_mg))
    lib.faults_blocks_weigh(chain, *arrays, len(raw))
    return Weighed(held, flags, mass_mg)
