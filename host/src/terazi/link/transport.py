# SPDX-License-Identifier: MIT
"""What carries the bytes. A link takes its time from its transport, too: on the simulated bench
that clock is the simulation's, so that a time-out means the same there as on a desk.
"""

import errno
import os
import time
from typing import Protocol

import serial

from terazi.errors import PortBusy, PortMissing, PortVanished, UsageError

BAUD_DEFAULT = 115_200  # of the boot loader, always, and of a program that was told no other
BAUDS = (BAUD_DEFAULT, 500_000, 1_000_000)  # what a program may speak: the setting uart.baud

# A frame of 30 bytes takes 2.6 ms at 115 200 baud: having seen its first byte, wait for the rest,
# so that a chunk is mostly whole frames and its time of arrival is worth noting.
GATHER_S = 0.004


class Transport(Protocol):
    """Anything that carries bytes both ways."""

    def read(self, timeout_s: float) -> bytes:
        """Wait for bytes, at most timeout_s, and give those there are; b"" if there are none.

        Raises PortVanished when there will never be any more.
        """

    def write(self, data: bytes) -> None:
        """Send all of data. Raises PortVanished when it cannot be sent any more."""

    def now_s(self) -> float:
        """Seconds on the clock by which this transport's time-outs run; any origin."""

    def close(self) -> None:
        """Let go of the port; a second call does nothing."""


class SerialTransport:
    """A serial port through pyserial, for this program alone.

    Opening resets an Arduino Uno: DTR rises, and a capacitor turns that into a reset pulse.
    A pseudo-terminal has no DTR; that is no error.
    """

    def __init__(self, port: str, baud: int = BAUD_DEFAULT) -> None:
        self.port = port
        self.baud = baud
        try:
            self._serial = serial.Serial(port, baud, timeout=0, write_timeout=2.0, exclusive=True)
        except (OSError, ValueError, OverflowError) as error:
            raise _why_not_opened(port, baud, error) from error

    def set_baud(self, baud: int) -> None:
        """Speak at another rate from now on. The port stays open, so that nothing is reset."""
        try:
            self._serial.baudrate = baud
        except (ValueError, OverflowError) as error:
            raise _why_not_opened(self.port, baud, error) from error
        except OSError as error:
            raise self._vanished() from error
        self.baud = baud

    def read(self, timeout_s: float) -> bytes:
        try:
            self._serial.timeout = timeout_s
            data = self._serial.read(1)
        except (OSError, TypeError) as error:
            raise self._vanished() from error
        if not data:
            return data
        time.sleep(GATHER_S)
        try:
            self._serial.timeout = 0
            return data + self._serial.read(self._serial.in_waiting)
        except (OSError, TypeError):
            return data  # the next call will say that the port is gone

    def write(self, data: bytes) -> None:
        try:
            self._serial.write(data)
        except serial.SerialTimeoutException as error:
            raise PortVanished(f"{self.port} takes no more bytes") from error
        except OSError as error:
            raise self._vanished() from error

    def now_s(self) -> float:
        return time.monotonic()

    def close(self) -> None:
        self._serial.close()

    def _vanished(self) -> PortVanished:
        return PortVanished(
            f"{self.port} vanished",
            remedy="Check the cable and the board's power, then start again.",
        )


def _why_not_opened(port: str, baud: int, error: Exception) -> Exception:
    """pyserial says everything with one exception; tell its cases apart."""
    number = getattr(error, "errno", None)
    if number in (errno.EWOULDBLOCK, errno.EAGAIN, errno.EBUSY):
        return PortBusy(
            f"{port} is in use by another program",
            remedy="Close the Arduino IDE's monitor, another terazi, or what `fuser -v "
            f"{port}` names.",
        )
    if number == errno.EACCES:
        return PortBusy(
            f"permission denied: {port}",
            remedy="Add yourself to the dialout group: sudo usermod -aG dialout $USER; "
            "then log out and in.",
        )
    if isinstance(error, (ValueError, OverflowError)):
        return UsageError(f"{port} cannot run at {baud} baud")
    if not os.path.lexists(port):
        return PortMissing(
            f"there is no port {port}", remedy="`terazi ports` lists those that there are."
        )
    if not os.path.exists(port):
        return PortMissing(
            f"{port} is a link to {os.path.realpath(port)}, which is not there",
            remedy="Start again what made the link, or name another port.",
        )
    return PortMissing(
        f"{port} cannot be opened as a serial port",
        remedy="`terazi ports` lists those that there are.",
    )
