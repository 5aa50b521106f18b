# SPDX-License-Identifier: MIT
"""frame of shared_c: bytes of the wire to frames and back."""

from __future__ import annotations

from dataclasses import dataclass

from terazi.cshared._cshared import ffi, lib


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame of the wire; shared_c/PROTOCOL.md says what its payload means."""

    id: int
    sequence: int
    device_us: int
    payload: bytes


def crc16(data: bytes) -> int:
    """CRC-16/MCRF4XX of at most 255 bytes."""
    if len(data) > 255:
        raise ValueError("frame_crc16 takes at most 255 bytes")
    return lib.frame_crc16(data, len(data))


def encode_frame(id: int, sequence: int, device_us: int, payload: bytes) -> bytes:
    """The frame's bytes, delimiter included. A host sends device_us 0."""
    if len(payload) > lib.FRAME_PAYLOAD_MAX:
        raise ValueError(f"payload has {len(payload)} bytes, more than {lib.FRAME_PAYLOAD_MAX}")
    held = ffi.new("uint8_t[]", bytes(payload))
    fields = {
        "id": id,
        "sequence": sequence,
        "device_us": device_us,
        "payload_len": len(payload),
        "payload": held,
    }
    try:
        frame = ffi.new("frame_t *", fields)
    except OverflowError as error:
        raise ValueError(f"frame: {error}") from None
    wire = ffi.new("uint8_t[]", lib.FRAME_WIRE_MAX)
    return bytes(ffi.buffer(wire, lib.frame_encode(wire, 0, frame)))


class FrameDecoder:
    """Takes bytes in pieces of any size; gives the good frames and counts the bad ones."""

    def __init__(self):
        self._c = ffi.new("frame_decoder_t *")
        lib.frame_decoder_init(self._c, lib.FRAME_BODY_MAX)
        self.bad_cobs = 0
        self.bad_len = 0
        self.bad_crc = 0

    @property
    def bad_frames(self) -> int:
        """All that was refused so far."""
        return self.bad_cobs + self.bad_len + self.bad_crc

    def feed(self, data: bytes) -> list[Frame]:
        """Frames that these bytes complete."""
        frames = []
        held = ffi.from_buffer("uint8_t[]", data)
        used = ffi.new("size_t *")
        at, left = held + 0, len(data)
        while left:
            status = lib.blocks_decode(self._c, at, left, used)
            at, left = at + used[0], left - used[0]
            if status == lib.FRAME_READY:
                frames.append(self._read())
            elif status == lib.FRAME_BAD_COBS:
                self.bad_cobs += 1
            elif status == lib.FRAME_BAD_LEN:
                self.bad_len += 1
            elif status == lib.FRAME_BAD_CRC:
                self.bad_crc += 1
        return frames

    def _read(self) -> Frame:
        frame = ffi.new("frame_t *")
        lib.frame_decoder_read(self._c, frame)
        payload = bytes(ffi.buffer(frame.payload, frame.payload_len))
        return Frame(frame.id, frame.sequence, frame.device_us, payload)

    def copy(self) -> FrameDecoder:
        """Another decoder in the same state, counters included."""
        twin = object.__new__(FrameDecoder)
        twin.__dict__.update(self.__dict__)
        twin._c = ffi.new("frame_decoder_t *", self._c[0])
        return twin
