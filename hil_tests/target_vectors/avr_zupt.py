# SPDX-License-Identifier: MIT
"""zupt as it runs on the chip; the wire is described in ``runner_zupt.c``."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence

from target_vectors.avr_core import AvrCore

SAMPLES_PER_REQUEST = 20
CONFIG = struct.Struct("<2i5B")  # zupt_config_t; the chip pads nothing
FIELDS = ("detector", "acc_weight", "gyro_weight", "still_blocks", "stride")


def zupt_init(core: AvrCore, config: Mapping) -> bool:
    """Whether the chip takes the configuration."""
    packed = CONFIG.pack(*config["begin_squares"], *(config[field] for field in FIELDS))
    return bool(core.request("i", packed)[0])


def zupt_choose(core: AvrCore, detector: int, rate: int) -> dict:
    """The configuration that the chip has in its program memory."""
    enter, leave, *rest = CONFIG.unpack(core.request("o", bytes([detector, rate])))
    return {"begin_squares": [enter, leave], **dict(zip(FIELDS, rest, strict=True))}


def zupt(core: AvrCore, samples: Sequence[Sequence[int]]) -> list[int]:
    """The flag after each sample of gyro x y z, acc x y z."""
    flags: list[int] = []
    for at in range(0, len(samples), SAMPLES_PER_REQUEST):
        part = samples[at : at + SAMPLES_PER_REQUEST]
        flags += core.request("u", b"".join(struct.pack("<6h", *sample) for sample in part))
    return flags


def zupt_interrupt(core: AvrCore) -> None:
    """A gap."""
    core.request("x")


def zupt_rejected(core: AvrCore) -> int:
    """Samples on a rail."""
    return struct.unpack("<H", core.request("n"))[0]


def config_of(vector) -> dict:
    """The configuration that a golden vector names."""
    limits = [vector.parameter(f"begin_{side}_squares") for side in ("enter", "leave")]
    return {"begin_squares": limits} | {field: vector.parameter(field) for field in FIELDS}


def samples_of(vector) -> list[tuple[int, ...]]:
    """Its samples."""
    names = [f"{sensor}_{axis}_counts" for sensor in ("gyro", "acc") for axis in "xyz"]
    return list(zip(*(vector[name] for name in names), strict=True))
