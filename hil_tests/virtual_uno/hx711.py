# SPDX-License-Identifier: GPL-3.0-or-later
"""The simulated HX711: its figures, its faults, its truth, and the part on its own."""

import numpy as np

from virtual_uno.core_lib import ffi, lib

COUNTS_PER_GRAM = 429.55  # 5 kg cell of 1 mV/V: 1 LSB = 2.328 mg
# rms noise at gain 128, HX711 datasheet p. 3: 50 nV at 10 SPS, 90 nV at 80 SPS; 2.328 nV a LSB
NOISE_COUNTS_10_SPS = 21.5
NOISE_COUNTS_80_SPS = 38.7

RECORD = np.dtype(
    [
        ("tick", "u8"),
        ("source", "f8"),
        ("counts", "i4"),
        ("pulses", "u1"),
        ("gain", "u1"),
        ("settling", "u1"),
        ("read", "u1"),
    ],
    align=True,
)
FAULTS = {
    "dout_high": {},
    "dout_low": {},
    "bit_lost": {"bit": 12, "frames": 1},
    "late": {"seconds": 0.3},
    "cable_out": {},
    "rail": {"side": "high"},
    "noisy_line": {"probability": 0.01},
    "frozen": {},
    "noise": {"counts": 200_000.0},
    "rate": {"factor": 3.0},
    "glitch": {},
    "conversion_lost": {"count": 1},
    "stretched": {"bit": 12, "frames": 1},
}


def make_config(rate_sps, *, jitter_s, noise_counts, seed, update_pulse_s, gain_kept):
    """The C core's configuration struct."""
    if not rate_sps > 0:
        raise ValueError(f"rate {rate_sps} SPS is not positive")
    return ffi.new(
        "hx711_config_t *",
        {
            "rate_hz": rate_sps,
            "jitter_s": jitter_s,
            "noise_counts": noise_counts,
            "seed": seed,
            "update_pulse_s": update_pulse_s,
            "gain_after_power_down_kept": gain_kept,
        },
    )


def apply_fault(fault, name, clock_hz, **how):
    """Set one named misbehaviour in a ``hx711_fault_t``."""
    if name not in FAULTS:
        raise ValueError(f"no fault {name!r}; there are {', '.join(FAULTS)}")
    unknown = set(how) - set(FAULTS[name])
    if unknown:
        raise TypeError(f"fault {name!r} knows no {', '.join(sorted(unknown))}")
    how = {**FAULTS[name], **how}
    if name == "dout_high":
        fault.dout_stuck_high = 1
    elif name == "dout_low":
        fault.dout_stuck_low = 1
    elif name == "bit_lost":
        if not 1 <= how["bit"] <= 25:
            raise ValueError("a frame's pulses are 1..25")
        fault.lost_pulse, fault.lost_pulse_frames = how["bit"], how["frames"]
    elif name == "late":
        fault.late_ticks = round(how["seconds"] * clock_hz)
    elif name == "cable_out":
        fault.cable_out = 1
    elif name == "rail":
        fault.rail = {"high": 1, "low": -1}[how["side"]]
    elif name == "noisy_line":
        fault.flip_probability = how["probability"]
    elif name == "frozen":
        fault.frozen = 1
    elif name == "noise":
        fault.noise_counts = how["counts"]
    elif name == "rate":
        if not how["factor"] > 0:
            raise ValueError("a clock's factor is positive")
        fault.rate_factor = how["factor"]
    elif name == "glitch":
        fault.restarted = 1
    elif name == "conversion_lost":
        fault.lost_conversions = how["count"]
    elif name == "stretched":
        if not 1 <= how["bit"] <= 25:
            raise ValueError("a frame's pulses are 1..25")
        fault.stretched_pulse, fault.stretched_frames = how["bit"], how["frames"]


def read_stats(hx711):
    """Counters of a core HX711 as a dict."""
    stats = ffi.new("hx711_stats_t *")
    lib.hx711_get_stats(hx711, stats)
    return {name: getattr(stats, name) for name, _ in ffi.typeof("hx711_stats_t").fields}


def read_records(hx711, first=0):
    """Every conversion since construction, from index ``first``, as a RECORD array."""
    assert RECORD.itemsize == ffi.sizeof("hx711_record_t")
    count = max(lib.hx711_record_count(hx711) - first, 0)
    records = np.empty(count, RECORD)
    target = ffi.cast("hx711_record_t *", ffi.from_buffer(records)) if count else ffi.NULL
    lib.hx711_get_records(hx711, target, first, count)
    return records


class Hx711:
    """The part alone, driven by edges at instants of any clock; for tests of the part."""

    def __init__(self, ticks_per_s, *, rate_sps=80.0, counts=0.0, first_conversion_s=None):
        config = make_config(
            rate_sps, jitter_s=0, noise_counts=0, seed=1, update_pulse_s=0, gain_kept=False
        )
        self._hx711 = ffi.gc(lib.hx711_new(ticks_per_s, config), lib.hx711_free)
        lib.hx711_set_constant(self._hx711, counts)
        first_s = 1.0 / rate_sps if first_conversion_s is None else first_conversion_s
        lib.hx711_start(self._hx711, 0, first_s)

    def set_counts(self, counts):
        """The signal from the next conversion on."""
        lib.hx711_set_constant(self._hx711, counts)

    def sck(self, tick, level):
        """PD_SCK goes to ``level`` at ``tick``; ticks must not go back."""
        lib.hx711_sck(self._hx711, tick, level)

    def advance(self, tick):
        """Let time pass without an edge."""
        lib.hx711_advance(self._hx711, tick)

    @property
    def dout(self):
        """Level of DOUT."""
        return lib.hx711_dout(self._hx711)

    @property
    def dout_changed_tick(self):
        """When DOUT last moved."""
        return lib.hx711_dout_changed_tick(self._hx711)

    @property
    def stats(self):
        """Counters, see ``hx711_stats_t`` in core/uno.h."""
        return read_stats(self._hx711)

    @property
    def records(self):
        """All conversions so far."""
        return read_records(self._hx711)
