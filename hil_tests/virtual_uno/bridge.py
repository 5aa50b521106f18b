# SPDX-License-Identifier: GPL-3.0-or-later
"""The board on a pseudo-terminal, paced in real time or at another speed.

Opening the port resets the chip, as DTR does on a real Uno; the terminal's baud rate is the
host's. When the reader does not keep up, simulated time waits: no byte is dropped.
"""

import os
import select
import termios
import time
import tty

from virtual_uno.openings import Openings

BAUD_OF_CODE = {
    getattr(termios, name): int(name[1:])
    for name in dir(termios)
    if name.startswith("B") and name[1:].isdigit() and name != "B0"
}
SLICE_S = 0.002  # of real time between looks at the port
SLICE_MAX_S = 0.1  # of simulated time
IDLE_S = 0.005  # between looks while simulated time stands still
CATCH_UP_S = 0.25  # more delay than this is forgotten: a stopped laptop must not race later
READ_BYTES = 4096


class Bridge:
    """Runs a board and carries its bytes to and from a pseudo-terminal at ``path``."""

    def __init__(self, uno, *, on_reset=None, on_slice=None):
        self._uno = uno
        self._on_reset = on_reset
        self._on_slice = on_slice
        self._master, slave = os.openpty()
        tty.setraw(slave)
        self.path = os.ttyname(slave)
        os.close(slave)
        os.set_blocking(self._master, False)
        self._openings = Openings(self._master, self.path)
        self._pending = b""
        self._stopped = False
        self.resets = 0

    def close(self):
        """Take the port away, as a pulled cable does."""
        self._openings.close()
        os.close(self._master)

    def stop(self, *_):
        """End ``run`` after the slice under way; fit as a signal handler."""
        self._stopped = True

    def run(self, speed=1.0, seconds=None):
        """Run until ``stop`` or for so many simulated seconds.

        speed : simulated seconds a second; 0 is as fast as possible, and then time stands still
            while nobody has the port open.
        """
        uno = self._uno
        started_s = uno.seconds
        slice_s = min(SLICE_S * speed, SLICE_MAX_S) if speed else 5 * SLICE_S
        base_wall_s, base_s = time.monotonic(), uno.seconds
        while not self._stopped and not (seconds and uno.seconds - started_s >= seconds):
            self._pump()
            if self._pending or not (speed or seconds or self._openings.held):
                self._wait(IDLE_S)
                base_wall_s, base_s = time.monotonic(), uno.seconds
                continue
            uno.run(slice_s)
            if self._on_slice:
                self._on_slice()
            if speed:
                ahead_s = (uno.seconds - base_s) / speed - (time.monotonic() - base_wall_s)
                if ahead_s > 0:
                    self._wait(ahead_s)
                elif ahead_s < -CATCH_UP_S:
                    base_wall_s, base_s = time.monotonic(), uno.seconds
        self._pump()

    def _wait(self, wait_s):
        """Sleep, but look up when the host has sent something."""
        if self._openings.held and not self._pending:
            select.select([self._master], [], [], wait_s)
        else:
            time.sleep(wait_s)

    def _pump(self):
        happened = self._openings.look()
        for event in happened:
            if event == "opened":
                self._reset()
            else:
                self._hung_up()
        if not self._openings.held:
            self._uno.uart.discard()
            return
        self._follow_baud()
        self._uno.uart.write(self._read())
        self._pending += self._uno.uart.read()
        while self._pending:
            try:
                self._pending = self._pending[os.write(self._master, self._pending) :]
            except BlockingIOError:
                break

    def _read(self):
        try:
            return os.read(self._master, READ_BYTES)
        except OSError:  # empty, or hung up since the look
            return b""

    def _hung_up(self):
        """Nobody held the port: what was on its way in either direction is gone."""
        self._pending = b""
        if not self._openings.held:  # else it may be the next holder's already
            while self._read():
                pass
        self._uno.uart.cancel()
        slave = os.open(self.path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        termios.tcflush(slave, termios.TCIFLUSH)
        os.close(slave)
        self._openings.forget()

    def _reset(self):
        self._uno.reset("external")
        self._uno.uart.discard()
        self.resets += 1
        if self._on_reset:
            self._on_reset()

    def _follow_baud(self):
        baud = BAUD_OF_CODE.get(termios.tcgetattr(self._master)[5])
        if baud and baud != self._uno.uart.host_baud:
            self._uno.uart.host_baud = baud
