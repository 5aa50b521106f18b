# SPDX-License-Identifier: MIT
"""mahony as it runs on the chip; the wire is described in ``runner_mahony.c``."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence

from target_vectors.avr_core import AvrCore

SAMPLES_PER_REQUEST = 7
COUNTS = ("acc_zero", "railed", "mag_refused", "mag_disturbed", "gaps")
# mahony_modes_config_t's fields in order; the chip pads nothing.
CONFIG_LAYOUT = {
    "gyro_q33": "H",
    "square": "H",
    "cubic": "H",
    "lowpass_q16": "H",
    "correct_q18": "H",
    "acc_one_g": "H",
    "ramp_mask": "B",
    "gap_max": "B",
    "start_shift": "B",
    "mag_correct_q21": "H",
    "mag_learn_q16": "H",
    "mag_recover_len": "H",
    "mag_accept_len": "H",
    "mag_reject_len": "H",
    "moving_min": "H",
    "steps": "B",
    "mode": "B",
    "integral": "H",
}


def mahony(
    core: AvrCore, config: Mapping[str, int], samples: Sequence[Sequence[int]], *, axes: int
) -> tuple[list[tuple[int, ...]], dict[str, int]]:
    """(quaternion w x y z, roll, pitch, yaw) after each sample, and the counts.

    A sample is gap_samples, gyro, acc and mag x y z, bias x y z.
    """
    fields = [config[field] for field in CONFIG_LAYOUT]
    layout = "<B" + "".join(CONFIG_LAYOUT.values())
    if core.request("0", struct.pack(layout, axes, *fields)) != b"\1":
        raise ValueError("the chip refuses the configuration")
    results = go_on(core, samples)
    counts = struct.unpack("<5H", core.request("2"))
    return results, dict(zip(COUNTS, counts, strict=True))


def go_on(core: AvrCore, samples: Sequence[Sequence[int]]) -> list[tuple[int, ...]]:
    """What `mahony` gives, of the filter as it stands."""
    results: list[tuple[int, ...]] = []
    for at in range(0, len(samples), SAMPLES_PER_REQUEST):
        part = samples[at : at + SAMPLES_PER_REQUEST]
        reply = core.request("1", b"".join(struct.pack("<H9h3i", *sample) for sample in part))
        results += struct.iter_unpack("<4i3h", reply)
    return results


def start_chain(core: AvrCore) -> None:
    """Start rest; `mahony` must have set up the filter."""
    core.request("4")


def chain(core: AvrCore, samples: Sequence[Sequence[int]]) -> None:
    """rest and mahony over samples, as a device runs them; start_chain comes before."""
    packed = [struct.pack("<H9h3i", *sample) for sample in samples]
    for at in range(0, len(packed), SAMPLES_PER_REQUEST):
        core.request("5", b"".join(packed[at : at + SAMPLES_PER_REQUEST]))


def free_acceleration(core: AvrCore, acc: Sequence[int]) -> tuple[int, ...]:
    """acc less gravity at the attitude that the chip has now."""
    return struct.unpack("<3h", core.request("3", struct.pack("<3h", *acc)))
