# SPDX-License-Identifier: MIT
"""faults as it runs on the chip; the wire is described in ``runner_faults.c``."""

from __future__ import annotations

import struct
from collections.abc import Iterable

from target_vectors.avr_core import REQUEST_MAX, AvrCore

ROW = struct.Struct("<Bi")
ROWS_PER_REQUEST = REQUEST_MAX // ROW.size


def faults(
    core: AvrCore, noise_counts: int, rows: Iterable[tuple[int, int]]
) -> tuple[list[tuple[int, int]], int]:
    """(answer, held) after each (event, counts), and what was seen."""
    core.request("i", struct.pack("<H", noise_counts))
    story, told = list(rows), []
    for at in range(0, len(story), ROWS_PER_REQUEST):
        part = b"".join(ROW.pack(*row) for row in story[at : at + ROWS_PER_REQUEST])
        told += struct.iter_unpack("<BB", core.request("u", part))
    return told, core.request("s")[0]
