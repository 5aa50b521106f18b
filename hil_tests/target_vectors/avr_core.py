# SPDX-License-Identifier: MIT
"""The shared modules as they run on the chip: ``runner.elf`` in the simulator, driven from here.

The same calls as ``terazi.cshared`` offers, so that one test can judge both builds. The wire to
the runner is described in ``runner_main.c``.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

from virtual_uno import Uno

RUNNER_BAUD = 2_000_000
REQUEST_MAX = 255
FIR_LOADED = 255
VALUES_PER_REQUEST = REQUEST_MAX // 4
START_UP_S = 1e-3  # clearing .bss takes 0.3 ms; then the USART listens
REPLY_TIMEOUT_S = 2.0  # simulated; the longest request takes about 20 ms


class AvrCore:
    """One simulated chip with the vector runner in it."""

    def __init__(self, elf: Path) -> None:
        self._uno = Uno(elf)
        self._uno.uart.host_baud = RUNNER_BAUD
        self._uno.run(START_UP_S)

    def profile(self, functions: Sequence[str]):
        """Context manager that counts the cycles of functions of the runner."""
        return self._uno.profile(functions)

    def request(self, op: str, payload: bytes = b"") -> bytes:
        if len(payload) > REQUEST_MAX:
            raise ValueError(f"{len(payload)} bytes do not fit a request of {REQUEST_MAX}")
        reply = bytearray()

        def complete() -> bool:
            reply.extend(self._uno.uart.read())
            return bool(reply) and len(reply) == 1 + reply[0]

        self._uno.uart.write(op.encode() + bytes([len(payload)]) + payload)
        self._uno.run_until(complete, timeout_s=REPLY_TIMEOUT_S)
        return bytes(reply[1:])

    def _stream(self, op: str, values: Sequence[int]) -> list[int]:
        results: list[int] = []
        for start in range(0, len(values), VALUES_PER_REQUEST):
            part = values[start : start + VALUES_PER_REQUEST]
            reply = self.request(op, struct.pack(f"<{len(part)}i", *part))
            results.extend(struct.unpack(f"<{len(part)}i", reply))
        return results

    def _u16(self, op: str, payload: bytes = b"") -> int:
        return struct.unpack("<H", self.request(op, payload))[0]

    def fir(
        self,
        design: int | Sequence[int],
        first_counts: int,
        samples: Sequence[int],
        *,
        by_heart: bool = False,
    ) -> tuple[list[int], int]:
        """Results and the count of clipped values. A design by index, or all coefficients of one
        to be loaded; by_heart: by the way that knows the default design's coefficients."""
        if not isinstance(design, int):
            if not self.fir_load(design):
                raise ValueError(f"the chip refuses coefficients {list(design)}")
            design = FIR_LOADED
        self.request("f", struct.pack("<Bi", design, first_counts))
        return self._stream("q" if by_heart else "F", samples), self._u16("c")

    def fir_load(self, taps_q15: Sequence[int]) -> bool:
        """Whether the chip takes these coefficients."""
        half = taps_q15[: (len(taps_q15) + 1) // 2]
        return bool(self.request("a", struct.pack(f"<B{len(half)}h", len(taps_q15), *half))[0])

    def weight_kf(
        self, schedule: int, first_counts: int, measured: Sequence[int]
    ) -> tuple[list[int], int]:
        """Estimates (Q7) and the count of clipped measurements."""
        self.request("k", struct.pack("<Bi", schedule, first_counts))
        return self._stream("K", measured), self._u16("l")

    def mass_mg(self, net_counts_q7: int, span_ug_per_count_q16: int) -> int:
        payload = struct.pack("<iI", net_counts_q7, span_ug_per_count_q16)
        return struct.unpack("<i", self.request("M", payload))[0]

    def crc16(self, data: bytes) -> int:
        return self._u16("C", data)

    def encode(self, frame_id: int, sequence: int, device_us: int, payload: bytes) -> bytes:
        return self.request("E", struct.pack("<BBI", frame_id, sequence, device_us) + payload)

    def decode(self, wire: bytes) -> tuple[list[int], bytes]:
        """Status after each byte, and the body (without CRC) of the frame last decoded."""
        self.request("d")
        return list(self.request("D", wire)), self.request("g")
