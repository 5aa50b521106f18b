# SPDX-License-Identifier: MIT
"""weight_kf_adaptive as it runs on the chip; the wire is described in ``runner_adaptive.h``."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from target_vectors.avr_core import AvrCore

VALUES_PER_REQUEST = 60


def adaptive(
    core: AvrCore, variant: int, first_counts: int, measured: Sequence[int], *, pair: bool = False
) -> tuple[list[int], int]:
    """Estimates (Q7) and the count of clipped measurements."""
    core.request("v" if pair else "u", struct.pack("<Bi", variant, first_counts))
    estimates: list[int] = []
    for start in range(0, len(measured), VALUES_PER_REQUEST):
        part = measured[start : start + VALUES_PER_REQUEST]
        reply = core.request("V" if pair else "U", struct.pack(f"<{len(part)}i", *part))
        estimates.extend(struct.unpack(f"<{len(part)}i", reply))
    return estimates, struct.unpack("<H", core.request("w"))[0]
