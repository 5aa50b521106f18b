# SPDX-License-Identifier: MIT
"""The board that a case talks to: a simulated Uno in lock step, or any Uno on a serial port.

Both offer one interface. What only a simulated board can do (place a load, break a wire, tell the
truth) skips on a real one, saying what it cannot do.
"""

import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from terazi.link import Link, SerialTransport
from terazi.link.generated.messages import Sample

IMAGE = Path(__file__).resolve().parents[1] / ".build" / "firmware" / "terazi.elf"

SLICE_S = 0.005  # simulated time between looks at the serial line
HELLO_S = 3.0  # optiboot listens for a second after a reset
DTR_PAUSE_S = 0.1  # a port closed and opened in one breath would not be seen to have been closed
NOISE_COUNTS = 5.0  # of the quietest converter; a simulated one has this where a case says nothing
SAMPLES_LATEST_S = 2.0  # at 10 SPS: 400 ms to settle, 100 ms each


@dataclass(frozen=True)
class RawCommand:
    """A command that no decent host would send; terazi.link takes it as it takes the others."""

    ID: int
    payload: bytes = b""

    def pack(self):
        return self.payload


class LockStepTransport:
    """Carries the bytes of a simulated board, and is what lets its time go by."""

    def __init__(self, uno):
        self._uno = uno

    def read(self, timeout_s):
        end_s = self._uno.seconds + timeout_s
        while not (data := self._uno.uart.read()) and self._uno.seconds < end_s:
            self._uno.run(min(SLICE_S, end_s - self._uno.seconds) + 1e-7)
        return data

    def write(self, data):
        self._uno.uart.write(data)

    def now_s(self):
        return self._uno.seconds

    def close(self):
        pass


class Board:
    """A board that has just started, with nothing read from it yet.

    link : terazi.link.Link over it; its clock is simulated where the board is.
    simulated : nothing comes between the board and its link: no boot loader that clears the
        reset cause, no port driver that drops what came before it was ready.
    """

    link: Link
    simulated: bool

    def wait(self, seconds):
        """Let time go by; gives the messages that came in, HELLO included."""
        end_s = self.link.now_s() + seconds
        received = []
        while (left_s := end_s - self.link.now_s()) > 0:
            received += self.link.poll(left_s)
        return received

    def samples(self, n):
        """The next n SAMPLE messages, each as terazi.link.Received."""
        found = []
        quiet_since_s = self.link.now_s()
        while len(found) < n:
            new = [one for one in self.link.poll(0.05) if isinstance(one.message, Sample)]
            if new:
                quiet_since_s = self.link.now_s()
            elif self.link.now_s() - quiet_since_s > SAMPLES_LATEST_S:
                raise AssertionError(f"{len(found)} of {n} samples came, then none for 2 s")
            found += new
        return found[:n]

    def write(self, data):
        """Raw bytes onto the line."""
        self.link.transport.write(data)

    def read_raw(self, seconds):
        """Raw bytes from the line, past the link, which sees none of them."""
        transport = self.link.transport
        end_s = transport.now_s() + seconds
        data = b""
        while (left_s := end_s - transport.now_s()) > 0:
            data += transport.read(left_s)
        return data


class VirtualBoard(Board):
    """A simulated Uno; `uno` is virtual_uno.Uno, with all that it can do."""

    simulated = True

    def __init__(self, **how):
        from virtual_uno import Uno  # only here: a real board needs no simulator

        # A converter has noise of its own: counts without any are a fault, and nothing is stable.
        self.uno = Uno(IMAGE, **{"noise_counts": NOISE_COUNTS} | how)
        self.link = Link(LockStepTransport(self.uno), name="the virtual Uno")

    def truth(self, _what):
        """The simulator itself."""
        return self.uno

    def load(self, **what):
        self.uno.load(**what)

    def fault(self, name, **how):
        self.uno.fault(name, **how)

    def clear_faults(self):
        self.uno.clear_faults()

    def reset(self, cause="external"):
        self.uno.reset(cause)

    def close(self):
        self.link.close()


class RealBoard(Board):
    """An Uno on a serial port. Opening the port resets it."""

    simulated = False

    def __init__(self, port):
        self._port = port
        self.link = Link(SerialTransport(port), name=port)

    def truth(self, what):
        pytest.skip(f"a real board cannot {what}")

    def load(self, **_what):
        pytest.skip("a real board cannot place a load by itself")

    def fault(self, name, **_how):
        pytest.skip(f"a real board cannot break its own wires: {name}")

    def clear_faults(self):
        """There are none."""

    def reset(self, cause="external"):
        if cause != "external":
            pytest.skip(f"a real board cannot be reset by {cause} from its serial port")
        self.close()
        self.link.transport = SerialTransport(self._port)

    def close(self):
        self.link.close()
        time.sleep(DTR_PAUSE_S)
