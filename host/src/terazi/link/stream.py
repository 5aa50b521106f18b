# SPDX-License-Identifier: MIT
"""From bytes to messages: decoded, checked, counted, and put on one time axis.

Used alike for a live port and for a recording, so that both lose and count the same.
"""

import struct
from dataclasses import dataclass
from typing import get_args

from terazi.cshared import Frame, FrameDecoder
from terazi.errors import FingerprintMismatch
from terazi.link.generated.messages import FINGERPRINT, MESSAGES_BY_ID, Hello, ToHost

CLOCK_PERIOD_US = 1 << 32  # the device's clock wraps after 71.6 minutes
SEQUENCE_PERIOD = 256

# A HELLO that is no more than this ahead of the frame before it answers a GET_INFO; any other
# says that the device has started anew. The ACK before it, or else STATUS, keeps the clock known.
HELLO_SAME_RUN_US = 10_000_000

# The head of HELLO never changes: fingerprint, version, build (shared_c/spec/messages.toml).
HELLO_HEAD = struct.Struct("<HBBBI")

FLASH_REMEDY = (
    "Put this version's firmware on the board with `terazi flash`, or use the terazi that fits it."
)

FROM_DEVICE = frozenset(get_args(ToHost))


@dataclass(frozen=True)
class Received:
    """A message as it came in."""

    message: ToHost
    sequence: int
    device_us: int  # the device's clock in this run of it, wraps undone
    boot: int  # runs of the device seen before this one
    host_s: float  # when the bytes had arrived, on the transport's clock
    lost_before: int  # frames missing between this one and the one before


class MessageStream:
    """Decodes what one device sends. Every count is of this host's making, not the device's."""

    def __init__(self, *, whose: str = "the board", remedy: str = FLASH_REMEDY) -> None:
        self._decoder = FrameDecoder()
        self._whose = whose
        self._remedy = remedy  # for a HELLO of another protocol
        self._sequence: int | None = None
        self._device_us = 0
        self._host_s: float | None = None  # of the last frame in this run
        self._bad_before_first = 0
        self.boot = 0
        self.bytes_in = 0
        self.frames = 0  # good ones
        self.frames_lost = 0  # by sequence number
        self.frames_unknown = 0  # good, but no message that the device may send
        self.hello: Hello | None = None  # the last one

    @property
    def frames_bad(self) -> int:
        """Frames refused for COBS, length or CRC since the first good one.

        What comes before is the tail of a frame that was under way when the port was opened.
        """
        return self._bad() - self._bad_before_first if self.frames else 0

    def feed(self, data: bytes, host_s: float) -> list[Received]:
        """Take bytes as they come, give the messages that they complete.

        Raises FingerprintMismatch at a HELLO of another protocol.
        """
        self.bytes_in += len(data)
        frames = self._decoder.feed(data) if self.frames else self._feed_until_first(data)
        received = (self._receive(frame, host_s) for frame in frames)
        return [one for one in received if one is not None]

    def _feed_until_first(self, data: bytes) -> list[Frame]:
        """Byte by byte, so that faults before the first good frame are told from those after."""
        for place in range(len(data)):
            self._bad_before_first = self._bad()
            frames = self._decoder.feed(data[place : place + 1])
            if frames:
                return frames + self._decoder.feed(data[place + 1 :])
        return []

    def _bad(self) -> int:
        return self._decoder.bad_cobs + self._decoder.bad_len + self._decoder.bad_crc

    def _receive(self, frame: Frame, host_s: float) -> Received | None:
        self.frames += 1
        kind = MESSAGES_BY_ID.get(frame.id)
        if kind is Hello:
            self._check_fingerprint(frame.payload)
        message = _message(kind, frame.payload)
        lost = self._count_lost(frame, starts_run=self._starts_run(kind, frame.device_us))
        self._device_us = self._unwrapped(frame.device_us, host_s)
        self._host_s = host_s
        if message is None:
            self.frames_unknown += 1
            return None
        if kind is Hello:
            self.hello = message
        return Received(message, frame.sequence, self._device_us, self.boot, host_s, lost)

    def _check_fingerprint(self, payload: bytes) -> None:
        if len(payload) < HELLO_HEAD.size:
            return
        theirs, major, minor, patch, _build = HELLO_HEAD.unpack_from(payload)
        if theirs != FINGERPRINT:
            raise FingerprintMismatch(
                theirs,
                FINGERPRINT,
                whose=f"{self._whose} (firmware {major}.{minor}.{patch})",
                remedy=self._remedy,
            )

    def _starts_run(self, kind: type | None, device_us: int) -> bool:
        if kind is not Hello or self._sequence is None:
            return False
        return (device_us - self._device_us) % CLOCK_PERIOD_US > HELLO_SAME_RUN_US

    def _count_lost(self, frame: Frame, *, starts_run: bool) -> int:
        """Frames missing before this one. At a new run of the device there is no saying."""
        lost = 0
        if starts_run:
            self.boot += 1
            self._device_us = frame.device_us
            self._host_s = None
        elif self._sequence is not None:
            lost = (frame.sequence - self._sequence - 1) % SEQUENCE_PERIOD
        self._sequence = frame.sequence
        self.frames_lost += lost
        return lost

    def _unwrapped(self, device_us: int, host_s: float) -> int:
        """The value that is congruent to device_us and nearest to where the clock should be.

        The host's clock bridges silences longer than half a period. A frame may be older than
        the one before it: a sample bears the moment of its conversion, not of its sending.
        """
        if self._host_s is None:
            return device_us
        silence_us = round((host_s - self._host_s) * 1e6)
        expected_us = self._device_us + silence_us
        behind_us = (expected_us - device_us) % CLOCK_PERIOD_US
        if behind_us > CLOCK_PERIOD_US // 2:
            behind_us -= CLOCK_PERIOD_US
        return expected_us - behind_us


def _message(kind: type | None, payload: bytes) -> ToHost | None:
    """The payload read, or None where it is none of the device's or not as its layout wants."""
    if kind not in FROM_DEVICE:
        return None
    try:
        return kind.unpack(payload)
    except ValueError:
        return None
