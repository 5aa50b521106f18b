# SPDX-License-Identifier: MIT
"""Captures made in memory by the test double's chain, whole or damaged on purpose."""

from collections.abc import Callable
from pathlib import Path

from host.tests.fake_device import RATE_HZ, Chain, steps_and_noise
from terazi.link.generated.messages import FINGERPRINT, ChainOrder, KfKind, SetChain, Tare
from terazi.recorder import CaptureWriter

METADATA = {
    "product": "terazi",
    "version": "0.1.0",
    "protocol_fingerprint": f"0x{FINGERPRINT:04X}",
    "started": "2026-01-01T12:00:00.000+00:00",
    "port": "/dev/ttyACM0",
    "baud": 115200,
}


class CaptureMaker:
    """Writes what a chain sends, message by message. `drop` is asked for each sample's index."""

    def __init__(self, path: Path, load: Callable[[float], int] = steps_and_noise) -> None:
        self.path = path
        self.chain = Chain(load)
        self._writer = CaptureWriter(path)
        self._writer.begin(METADATA)

    def say(self, message) -> None:
        self.put(self.chain.frame(message))

    def put(self, wire: bytes) -> None:
        self._writer.append(self.chain.device_us / 1e6 + 0.2, wire)

    def hello(self) -> "CaptureMaker":
        self.say(self.chain.hello())
        return self

    def samples(
        self,
        count: int,
        *,
        drop: Callable[[int], bool] = lambda index: False,
        change: Callable = lambda index, sample: sample,
        skip: int = 0,
        restart: bool = False,
    ) -> "CaptureMaker":
        """count samples. skip: conversions lost before the first; restart: primed anew there."""
        for index in range(count):
            first = index == 0
            sample = self.chain.sample(restart=restart and first, skip=skip if first else 0)
            wire = self.chain.frame(change(index, sample))
            if not drop(index):
                self.put(wire)
            if self.chain.conversion % round(RATE_HZ) == 0:
                self.say(self.chain.status())
        return self

    def tare(self, *, lose_ack: bool = False) -> "CaptureMaker":
        """A tare command and its ACK."""

        class Command:
            id, sequence, payload = Tare.ID, 0, b""

        wire = self.chain.answer(Command, mask=[3])
        if not lose_ack:
            self.put(wire)
        return self

    def set_chain(
        self, order: ChainOrder, kf_kind: KfKind, *, lose_hello: bool = False
    ) -> "CaptureMaker":
        """A set_chain command: its ACK and the HELLO behind it."""

        class Command:
            id, sequence, payload = SetChain.ID, 0, SetChain(order, kf_kind).pack()

        wire = self.chain.answer(Command, mask=[3])
        self.put(wire[: wire.index(0) + 1] if lose_hello else wire)
        return self

    def end(self) -> Path:
        self._writer.close(self.chain.device_us / 1e6 + 0.3)
        return self.path
