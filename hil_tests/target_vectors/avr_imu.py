# SPDX-License-Identifier: MIT
"""imu_cal and rest as they run on the chip; the wire is described in ``runner_imu.c``."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence

from target_vectors.avr_core import AvrCore

VECTORS_PER_REQUEST = 40
SAMPLES_PER_REQUEST = 18
# rest_config_t's fields in order; the chip pads nothing.
REST_LAYOUT = {
    "enter_acc_counts": "h",
    "leave_acc_counts": "h",
    "enter_gyro_counts": "h",
    "leave_gyro_counts": "h",
    "bias_max_counts": "h",
    "lowpass_q16": "h",
    "still_rounds": "B",
    "gain_len": "B",
    "gravity2_min": "H",
    "gravity2_max": "H",
}


def imu_cal_init(core: AvrCore, matrix_q16: Sequence[int], offset_q3: Sequence[int]) -> None:
    """Begin with these constants; the matrix row by row."""
    if core.request("i", struct.pack("<9h3h", *matrix_q16, *offset_q3)) != b"\1":
        raise ValueError("the chip refuses the calibration")


def imu_cal_apply(
    core: AvrCore, raws: Sequence[Sequence[int]]
) -> tuple[list[tuple[int, ...]], int]:
    """Calibrated vectors and the count of clipped ones."""
    results: list[tuple[int, ...]] = []
    for at in range(0, len(raws), VECTORS_PER_REQUEST):
        payload = b"".join(struct.pack("<3h", *raw) for raw in raws[at : at + VECTORS_PER_REQUEST])
        results += struct.iter_unpack("<3h", core.request("I", payload))
    return results, struct.unpack("<H", core.request("j"))[0]


def imu_cal_at_temperature(core: AvrCore, slope_q16: Sequence[int], warmth: int) -> tuple[int, ...]:
    """offset_q3 of what imu_cal_init was given, at this temperature above the reference."""
    return struct.unpack("<3h", core.request("t", struct.pack("<4h", *slope_q16, warmth)))


def imu_cal_turn(core: AvrCore, orientation: int, vector: Sequence[int]) -> tuple[int, ...] | None:
    """The vector on the board's axes; None where the chip finds the orientation unlawful."""
    lawful, *turned = struct.unpack(
        "<B3h", core.request("o", struct.pack("<B3h", orientation, *vector))
    )
    return tuple(turned) if lawful else None


def rest(
    core: AvrCore, config: Mapping[str, int], samples: Sequence[Sequence[int]]
) -> tuple[list[tuple[int, ...]], int, int]:
    """(flags, bias x, y, z) after each sample of gyro x y z, acc x y z; rejected, implausible."""
    fields = [config[field] for field in REST_LAYOUT]
    layout = "<" + "".join(REST_LAYOUT.values())
    if core.request("r", struct.pack(layout, *fields)) != b"\1":
        raise ValueError("the chip refuses the configuration")
    results: list[tuple[int, ...]] = []
    for at in range(0, len(samples), SAMPLES_PER_REQUEST):
        part = samples[at : at + SAMPLES_PER_REQUEST]
        reply = core.request("R", b"".join(struct.pack("<6h", *sample) for sample in part))
        results += struct.iter_unpack("<B3i", reply)
    return results, *struct.unpack("<HH", core.request("s"))
