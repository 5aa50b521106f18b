# SPDX-License-Identifier: MIT
"""Twins of shared_c in Python's unbounded integers, straight from the headers' contracts.

Slow, and written otherwise than the C on purpose: these give the golden vectors.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence

COUNTS_MIN, COUNTS_MAX = -(1 << 23), (1 << 23) - 1
INT32_MIN, INT32_MAX = -(1 << 31), (1 << 31) - 1
COUNTER_MAX = 65535


def rounded_shift(value: int, bits: int) -> int:
    """value / 2^bits, rounded half up."""
    return (value + (1 << bits - 1)) >> bits


class _Clamp:
    """Limits to 24 bits and counts how often it had to."""

    def __init__(self) -> None:
        self.count = 0

    def __call__(self, value: int) -> int:
        limited = min(max(value, COUNTS_MIN), COUNTS_MAX)
        if limited != value:
            self.count = min(self.count + 1, COUNTER_MAX)
        return limited


def fir(samples: Iterable[int], taps_q15: Sequence[int], first: int) -> tuple[list[int], int]:
    """Results of fir.h and its count of clipped values."""
    clamp = _Clamp()
    window = deque([clamp(first)] * len(taps_q15), maxlen=len(taps_q15))
    results = []
    for sample in samples:
        window.appendleft(clamp(sample))
        total = sum(tap * value for tap, value in zip(taps_q15, window, strict=True))
        results.append(clamp(rounded_shift(total, 15)))
    return results, clamp.count


def weight_kf(
    measured: Iterable[int], gains_q15: Sequence[int], first: int
) -> tuple[list[int], int]:
    """Estimates (Q7) of weight_kf.h and its count of clipped values."""
    clamp = _Clamp()
    estimate_q7 = clamp(first) * 128
    estimates = []
    for step, z in enumerate(measured):
        gain_q15 = gains_q15[min(step, len(gains_q15) - 1)]
        estimate_q7 += rounded_shift((clamp(z) * 128 - estimate_q7) * gain_q15, 15)
        estimates.append(estimate_q7)
    return estimates, clamp.count


def mass_mg(net_counts_q7: int, span_ug_per_count_q16: int) -> int:
    """Milligrams of mass.h."""
    divisor = (1 << 7 + 16) * 1000
    mass = (2 * net_counts_q7 * span_ug_per_count_q16 + divisor) // (2 * divisor)
    return min(max(mass, INT32_MIN), INT32_MAX)


def crc16_mcrf4xx(data: bytes) -> int:
    """CRC-16/MCRF4XX by polynomial division, bit by bit (reflected 0x1021, start 0xFFFF)."""
    remainder = 0xFFFF
    for byte in data:
        for bit in range(8):
            feedback = (remainder ^ byte >> bit) & 1
            remainder = remainder >> 1 ^ (0x8408 if feedback else 0)
    return remainder


def cobs_encode(body: bytes) -> bytes:
    """COBS without the delimiter (Cheshire and Baker 1999): blocks of up to 254 non-zeros."""
    coded = bytearray()
    pieces = body.split(b"\0")
    for place, piece in enumerate(pieces):
        while len(piece) >= 254:
            coded += b"\xff" + piece[:254]
            piece = piece[254:]
            if not piece and place == len(pieces) - 1:
                return bytes(coded)
        coded += bytes([len(piece) + 1]) + piece
    return bytes(coded)


def cobs_decode(coded: bytes) -> bytes | None:
    """What cobs_encode was given, or None where a code byte points past the end or is zero."""
    body, at = bytearray(), 0
    while at < len(coded):
        code = coded[at]
        block = coded[at + 1 : at + code]
        if code == 0 or len(block) != code - 1 or 0 in block:
            return None
        body += block
        at += code
        if code < 255 and at < len(coded):
            body.append(0)
    return bytes(body)


def frame_encode(id: int, sequence: int, device_us: int, payload: bytes) -> bytes:
    """A frame of frame.h, delimiter included."""
    body = bytes([id, sequence]) + device_us.to_bytes(4, "little") + payload
    return cobs_encode(body + crc16_mcrf4xx(body).to_bytes(2, "little")) + b"\0"


def frame_bodies(stream: bytes, body_max: int = 56) -> list[tuple[str, bytes]]:
    """What frame.h's decoder says of each piece of a stream that a zero ends: (status, body).

    status is "ready", "bad_cobs", "bad_len" or "bad_crc"; the body is without its CRC and empty
    unless ready. Empty pieces (idle line) and the unfinished tail say nothing.
    """
    said = []
    for piece in stream.split(b"\0")[:-1]:
        body = cobs_decode(piece)
        if not piece:
            continue
        if body is None:
            said.append(("bad_cobs", b""))
        elif not 8 <= len(body) <= body_max:
            said.append(("bad_len", b""))
        elif crc16_mcrf4xx(body[:-2]).to_bytes(2, "little") != body[-2:]:
            said.append(("bad_crc", b""))
        else:
            said.append(("ready", body[:-2]))
    return said
