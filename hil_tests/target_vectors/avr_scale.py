# SPDX-License-Identifier: MIT
"""scale and checkweigher as they run on the chip; the wire is described in ``runner_scale.c``."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from itertools import groupby

from target_vectors.avr_core import AvrCore

INIT, UPDATE, OUTCOME = 0, 1, 8
CHECK_INIT, CHECK, CHECK_DONE = 9, 10, 11
FIRST_COMMAND, LAST_COMMAND = 2, 7  # in the vectors 1..6; 0 is a sample
SAMPLES_PER_REQUEST = 14
ANSWER = struct.Struct("<B4i")
# scale_config_t's fields in order; the chip pads nothing.
SCALE_LAYOUT = {
    "max_mg": "i",
    "interval_mg": "i",
    "under_mg": "i",
    "step_mg": "i",
    "stable_band_mg": "i",
    "stable_us": "I",
    "gap_us": "I",
    "points": "B",
    "unit": "B",
    "decimals": "B",
    "digit": "B",
    "hysteresis_q8": "B",
    "options": "B",
    "spare": "2B",
    "point_counts_q7": "8i",
    "point_mass_mg": "8i",
}


def scale_init(core: AvrCore, config: Mapping) -> int:
    """scale_status_t."""
    fields: list[int] = []
    for field in SCALE_LAYOUT:
        value = config.get(field, [0, 0])  # spare bytes are nobody's
        fields += value if isinstance(value, list) else [value]
    layout = "<B" + "".join(SCALE_LAYOUT.values())
    return core.request("W", struct.pack(layout, INIT, *fields))[0]


def scale(core: AvrCore, rows: Iterable[tuple[int, ...]]) -> list[tuple[int, ...]]:
    """(answer, net, shown, pieces, mass) of rows (command, argument, raw, counts, time)."""
    answers: list[tuple[int, ...]] = []
    for is_command, group in groupby(rows, key=lambda row: row[0] != 0):
        part = list(group)
        if is_command:
            for command, argument, *_ in part:
                asked = struct.pack("<BH", command - 1 + FIRST_COMMAND, argument)
                answers.append(ANSWER.unpack(core.request("W", asked)))
            continue
        for at in range(0, len(part), SAMPLES_PER_REQUEST):
            samples = part[at : at + SAMPLES_PER_REQUEST]
            payload = b"".join(struct.pack("<iiI", *sample[2:]) for sample in samples)
            answers += ANSWER.iter_unpack(core.request("W", bytes([UPDATE]) + payload))
    return answers


def scale_outcome(core: AvrCore) -> tuple[int, ...]:
    """steps, step_us, step_from_mg, step_to_mg, kept_mg."""
    return struct.unpack("<HI3i", core.request("W", bytes([OUTCOME])))


CHECKWEIGHER_LAYOUT = {
    "limit_mg": "7i",
    "enter_mg": "i",
    "leave_mg": "i",
    "settle_us": "I",
    "tail_us": "I",
    "gap_us": "I",
    "classes": "B",
    "samples_min": "B",
}


def checkweigher_init(core: AvrCore, config: Mapping) -> bool:
    """Whether the chip takes the configuration."""
    fields: list[int] = []
    for field in CHECKWEIGHER_LAYOUT:
        fields += config[field] if isinstance(config[field], list) else [config[field]]
    layout = "<B" + "".join(CHECKWEIGHER_LAYOUT.values())
    return bool(core.request("W", struct.pack(layout, CHECK_INIT, *fields))[0])


def checkweigher(core: AvrCore, rows: Iterable[tuple[int, int]]) -> list[tuple[int, int]]:
    """(event, weighed) after each (mass, time)."""
    answers: list[tuple[int, int]] = []
    samples = list(rows)
    for at in range(0, len(samples), SAMPLES_PER_REQUEST):
        part = samples[at : at + SAMPLES_PER_REQUEST]
        payload = b"".join(struct.pack("<iI", *sample) for sample in part)
        answers += struct.iter_unpack("<Bi", core.request("W", bytes([CHECK]) + payload))
    return answers


def checkweigher_outcome(core: AvrCore) -> tuple[int, ...]:
    """weighed, unweighed, entered_us, left_us, per_minute_q8."""
    return struct.unpack("<IHIIH", core.request("W", bytes([CHECK_DONE])))
