# SPDX-License-Identifier: MIT
"""Samples as columns. Their names, types and units stand here once, for memory, CSV and Parquet.

Two clocks, never mixed: `host_s` is when the bytes arrived, in seconds since the recording began;
`device_us` is when the converter was done, on the device's own clock in run `boot` of it.
"""

from array import array

import numpy as np

from terazi import units
from terazi.link.generated.messages import SampleFlag, WeightFlag
from terazi.link.stream import Received

# name, array type code, numpy type
RAW_COLUMNS = [
    ("host_s", "d", np.float64),
    ("device_us", "q", np.int64),
    ("boot", "i", np.int32),
    ("sequence", "B", np.uint8),
    ("lost_before", "i", np.int32),  # frames missing since the sample before
    ("conversion", "H", np.uint16),
    ("raw_counts", "i", np.int32),
    ("fir_counts", "i", np.int32),
    ("kf_counts_q7", "i", np.int32),
    ("mass_mg", "i", np.int32),
    ("net_mg", "i", np.int32),
    ("flags", "B", np.uint8),
    ("weight_flags", "B", np.uint8),
]

TABLE_COLUMNS = [
    "host_s",
    "device_us",
    "boot",
    "sequence",
    "lost_before",
    "conversion",
    "raw_counts",
    "fir_counts",
    "kf_counts",
    "mass_g",
    "weight_g",
    "stable",
    "restarted",
    "at_rail",
    "gap",
]


class SampleColumns:
    """Grows by samples; gives numpy arrays."""

    def __init__(self) -> None:
        self._arrays = {name: array(code) for name, code, _dtype in RAW_COLUMNS}

    def __len__(self) -> int:
        return len(self._arrays["host_s"])

    def append(self, received: Received, lost_before: int) -> None:
        sample = received.message
        row = (
            received.host_s,
            received.device_us,
            received.boot,
            received.sequence,
            lost_before,
            sample.conversion,
            sample.raw_counts,
            sample.fir_counts,
            sample.kf_counts_q7,
            sample.mass_mg,
            sample.net_mg,
            int(sample.flags),
            int(sample.weight_flags),
        )
        for column, value in zip(self._arrays.values(), row, strict=True):
            column.append(value)

    def to_numpy(self) -> dict[str, np.ndarray]:
        return {name: np.array(self._arrays[name], dtype) for name, _code, dtype in RAW_COLUMNS}


def table_of(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The columns that CSV and Parquet show, in their order."""
    flags = columns["flags"]
    shown = dict(columns)
    shown["kf_counts"] = units.counts_from_q7(columns["kf_counts_q7"])
    shown["weight_g"] = units.g_from_mg(columns["net_mg"])
    shown["mass_g"] = units.g_from_mg(columns["mass_mg"])
    stable = columns["weight_flags"] & int(WeightFlag.STABLE)
    shown["stable"] = (stable != 0).astype(np.uint8)
    for name, flag in (
        ("restarted", SampleFlag.RESTARTED),
        ("at_rail", SampleFlag.AT_RAIL),
        ("gap", SampleFlag.GAP),
    ):
        shown[name] = (flags & int(flag) != 0).astype(np.uint8)
    return {name: shown[name] for name in TABLE_COLUMNS}
