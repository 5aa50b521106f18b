# SPDX-License-Identifier: MIT
"""A test double: something on a pseudo-terminal that speaks the true protocol, and can misbehave.

It is no firmware and knows no converter; the genuine firmware runs on the bench (hil_tests). It
resets when its port is opened, as an Uno does, and runs faster than time: no test need wait.
Where the machine has no time for it, it runs slower; it is never deaf while it makes up for that.
"""

import os
import random
import select
import termios
import threading
import time
import tty
from collections.abc import Callable

from host.tests.fake_chain import RATE_HZ, Chain, steps_and_noise
from host.tests.fake_commands import Eeprom
from host.tests.fake_imu import FakeImu
from terazi.cshared import FrameDecoder
from terazi.link import BAUDS
from terazi.link.generated.messages import FINGERPRINT
from terazi.link.generated.settings import SettingKey

SLICE_S = 0.002
CATCH_UP_S = 0.01  # the most that passes between two looks at the commands
BOOT_S = 0.05
SPEED_CODES = {115_200: termios.B115200, 500_000: termios.B500000, 1_000_000: termios.B1000000}


class FakeDevice:
    """A chain on a pseudo-terminal, in a thread of its own. Use it as a context manager."""

    def __init__(
        self,
        *,
        speed: float = 20.0,
        load: Callable[[float], int] = steps_and_noise,
        fingerprint: int = FINGERPRINT,
        speak: str = "frames",  # or "nothing", "garbage", "other" (bytes that are no frames)
        hello_at_reset: bool = True,
        answers: bool = True,
        ignore_commands: int = 0,
        lose_answers: int = 0,  # obeyed, but neither ACK nor answer arrives
        eeprom: Eeprom | None = None,
        vanish_after: int | None = None,  # samples
        silent_after: int | None = None,  # samples; then only STATUS, converter timed out
        lose: frozenset[int] = frozenset(),  # frames of these samples never leave
        corrupt: frozenset[int] = frozenset(),  # frames of these samples arrive broken
        noise_before: frozenset[int] = frozenset(),  # stray bytes on the line before these
        restart_at: frozenset[int] = frozenset(),  # samples at which the filters start anew
        imu: Callable[[], FakeImu] | None = None,  # makes one at each reset
        baud: int | None = None,  # it speaks and hears no other, but as saved; None: any
    ) -> None:
        self.speed = speed
        self.load = load
        self.fingerprint = fingerprint
        self.speak = speak
        self.hello_at_reset = hello_at_reset
        self.answers = answers
        self.ignore_commands = ignore_commands
        self.lose_answers = lose_answers
        self.eeprom = eeprom or Eeprom()
        self.vanish_after = vanish_after
        self.silent_after = silent_after
        self.lose, self.corrupt, self.restart_at = lose, corrupt, restart_at
        self.noise_before = noise_before
        self.imu = imu
        self.baud = baud
        self.resets = 0
        self.commands: list[int] = []
        self._garbage = random.Random(7)
        self._master, slave = os.openpty()
        tty.setraw(slave)
        self.path = os.ttyname(slave)
        os.close(slave)
        os.set_blocking(self._master, False)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> "FakeDevice":
        self._thread.start()
        return self

    def __exit__(self, *_exception) -> None:
        self._stop.set()
        self._thread.join()
        self._vanish()

    def _vanish(self) -> None:
        if self._master >= 0:
            os.close(self._master)
            self._master = -1

    def _run(self) -> None:
        poll = select.poll()
        poll.register(self._master, select.POLLIN)
        is_open = False
        while not self._stop.is_set():
            events = poll.poll(0)
            if events and events[0][1] & select.POLLHUP:
                is_open = False
                time.sleep(SLICE_S)
                continue
            if not is_open:
                is_open = True
                self._reset()
            if events:
                self._take(os.read(self._master, 4096))
            self._say()
            if self.vanish_after is not None and self.chain.samples >= self.vanish_after:
                time.sleep(0.1)  # what the host has not read by then goes down with the port
                self._vanish()
                return
            time.sleep(SLICE_S)

    def _reset(self) -> None:
        self.resets += 1
        self.chain = Chain(self.load, imu=self.imu() if self.imu else None)
        self.chain.fingerprint = self.fingerprint
        self.chain.start(self.eeprom)
        if self.baud is not None and SettingKey.UART_BAUD in self.eeprom.values:
            self.baud = BAUDS[self.eeprom.values[SettingKey.UART_BAUD]]
        self._decoder = FrameDecoder()
        self._statuses = 0
        time.sleep(BOOT_S)  # whoever opens a port discards what is stale in it, at once
        self._elapsed_s, self._looked_s = 0.0, time.monotonic()
        if self.speak == "frames" and self.hello_at_reset:
            self._send(self.chain.frame(self.chain.hello()))

    def _fits(self) -> bool:
        """Whether the host's end of the line runs at this one's rate."""
        if self.baud is None:
            return True
        return termios.tcgetattr(self._master)[5] == SPEED_CODES[self.baud]

    def _take(self, data: bytes) -> None:
        if not self._fits():
            data = self._garbage.randbytes(len(data))
        for frame in self._decoder.feed(data):
            self.commands.append(frame.id)
            if self.ignore_commands:
                self.ignore_commands -= 1
            elif self.answers and self.speak == "frames":
                answer = self.chain.answer(frame)
                if self.lose_answers:
                    self.lose_answers -= 1
                else:
                    self._send(answer)

    def _say(self) -> None:
        if self.speak == "garbage":
            self._send(self._garbage.randbytes(20))
        elif self.speak == "other":
            self._send(b"some other sketch\r\n")
        if self.speak != "frames":
            return
        looked_s, self._looked_s = self._looked_s, time.monotonic()
        self._elapsed_s += min(self._looked_s - looked_s, CATCH_UP_S) * self.speed
        while (self.chain.conversion + 1) / RATE_HZ <= self._elapsed_s:
            if self.vanish_after is not None and self.chain.samples >= self.vanish_after:
                return
            if self.silent_after is not None and self.chain.samples >= self.silent_after:
                self.chain.fall_silent()
                if fault := self.chain.fault():
                    self._send(self.chain.frame(fault))
            else:
                self._send_sample()
            if self.chain.device_us // 1_000_000 > self._statuses:
                self._statuses += 1
                for message in self.chain.health():
                    if self.chain.wants(message):
                        self._send(self.chain.frame(message))

    def _send_sample(self) -> None:
        index = self.chain.samples
        sample = self.chain.sample(restart=index in self.restart_at)
        if self.chain.wants(sample):
            self._send_disturbed(index, self.chain.frame(sample))
        self._send_unasked()

    def _send_disturbed(self, index: int, wire: bytes) -> None:
        if index in self.lose:
            return
        if index in self.corrupt:
            wire = wire[:1] + bytes([wire[1] ^ 0x40 or 0x41]) + wire[2:]
        if index in self.noise_before:
            wire = self._garbage.randbytes(40) + b"\0" + wire
        self._send(wire)

    def _send_unasked(self) -> None:
        for message, device_us in self.chain.unasked():
            if self.chain.wants(message):
                self._send(self.chain.frame(message, device_us))

    def _send(self, data: bytes) -> None:
        if not self._fits():  # fewer bits than bytes were sent; no one can read them
            data = self._garbage.randbytes(len(data) // 2)
        while data and not self._stop.is_set():
            try:
                data = data[os.write(self._master, data) :]
            except BlockingIOError:  # the host is slow: wait, never drop
                time.sleep(SLICE_S)
            except OSError:
                return
