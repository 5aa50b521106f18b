# SPDX-License-Identifier: GPL-3.0-or-later
"""The host's end of the board's serial line."""

import numpy as np

from virtual_uno.core_lib import ffi, lib


class Uart:
    """Bytes to and from the device; both take ten bit times each on the simulated wire."""

    def __init__(self, core):
        self._core = core
        self._host_baud = 115200.0

    @property
    def host_baud(self):
        """Baud rate of the host; far from the device's, bytes are garbled both ways."""
        return self._host_baud

    @host_baud.setter
    def host_baud(self, baud):
        if not baud > 0:
            raise ValueError(f"baud rate {baud} is not positive")
        self._host_baud = float(baud)
        lib.uno_uart_host_baud(self._core, self._host_baud)

    def write(self, data):
        """Queue bytes for the device; they go out one after the other from now on."""
        data = bytes(data)
        lib.uno_uart_write(self._core, data, len(data))
        return len(data)

    def read(self):
        """All bytes that have arrived since the last read."""
        return self.read_stamped()[0]

    def read_stamped(self):
        """(bytes, uint64 array): the bytes and the cycles at which their stop bits ended."""
        count = lib.uno_uart_available(self._core)
        data = bytearray(count)
        cycles = np.empty(count, np.uint64)
        lib.uno_uart_read(
            self._core,
            ffi.from_buffer("uint8_t[]", data, require_writable=True),
            ffi.cast("uint64_t *", ffi.from_buffer(cycles)),
            count,
        )
        return bytes(data), cycles

    @property
    def available(self):
        """Bytes that a read would give."""
        return lib.uno_uart_available(self._core)

    @property
    def backlog(self):
        """Bytes written that have not yet gone over the wire."""
        return lib.uno_uart_backlog(self._core)

    def discard(self):
        """Forget what has arrived."""
        lib.uno_uart_discard(self._core)

    def cancel(self):
        """Forget what the host has still to send."""
        lib.uno_uart_cancel(self._core)
