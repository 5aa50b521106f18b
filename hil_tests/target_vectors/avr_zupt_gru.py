# SPDX-License-Identifier: MIT
"""zupt_gru as it runs on the chip; the wire is described in ``runner_zupt_gru.c``."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from target_vectors.avr_core import AvrCore

SAMPLES_PER_REQUEST = 8
ANSWER = struct.Struct("<B10h")


def zupt_gru_init(core: AvrCore, sample_ms: int) -> None:
    """Begin anew; what was rejected stays counted."""
    core.request("i", bytes([sample_ms]))


def zupt_gru(core: AvrCore, samples: Sequence[Sequence[int]]) -> list[tuple[int, ...]]:
    """The flag, both inputs and eight states after each sample of gyro x y z, acc x y z."""
    answers: list[tuple[int, ...]] = []
    for at in range(0, len(samples), SAMPLES_PER_REQUEST):
        part = samples[at : at + SAMPLES_PER_REQUEST]
        packed = b"".join(struct.pack("<6h", *sample) for sample in part)
        answers += ANSWER.iter_unpack(core.request("u", packed))
    return answers


def zupt_gru_interrupt(core: AvrCore) -> None:
    """A gap."""
    core.request("x")


def zupt_gru_rejected(core: AvrCore) -> int:
    """Vectors on a rail."""
    return struct.unpack("<H", core.request("n"))[0]


def zupt_gru_steps(core: AvrCore, samples: Sequence[Sequence[int]]) -> None:
    """From a step on, at 1 kHz: all calls of a step with each sample."""
    for sample in samples:
        core.request("s", struct.pack("<6h", *sample))


def samples_of(vector) -> list[tuple[int, ...]]:
    """A golden vector's samples."""
    names = [f"{sensor}_{axis}_counts" for sensor in ("gyro", "acc") for axis in "xyz"]
    return list(zip(*(vector[name] for name in names), strict=True))


def answers_of(vector) -> list[tuple[int, ...]]:
    """What a golden vector says after each of them."""
    names = ["still", "input_0", "input_1", *(f"state_{n}" for n in range(8))]
    return list(zip(*(vector[name] for name in names), strict=True))


def run(core: AvrCore, vector) -> list[tuple[int, ...]]:
    """All of a golden vector, its gap included."""
    samples, gap = samples_of(vector), vector.parameter("gap")
    zupt_gru_init(core, vector.parameter("sample_ms"))
    answers = zupt_gru(core, samples[:gap])
    if gap:
        zupt_gru_interrupt(core)
    return answers + zupt_gru(core, samples[gap:])
