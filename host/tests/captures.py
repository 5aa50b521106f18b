# SPDX-License-Identifier: MIT
"""Captures made in memory by the test double's chain, whole or damaged on purpose."""

from collections.abc import Callable
from pathlib import Path

from host.tests.fake_chain import RATE_HZ, Chain, steps_and_noise
from host.tests.fake_imu import FakeImu
from terazi.design import scale as scale_design
from terazi.link.generated.messages import (
    FINGERPRINT,
    Ack,
    CalibrateEnd,
    ChainOrder,
    KfKind,
    Result,
    Setting,
    Tare,
)
from terazi.link.generated.settings import SETTINGS, SettingKey
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

    def __init__(
        self,
        path: Path,
        load: Callable[[float], int] = steps_and_noise,
        kf_kind: KfKind = KfKind.ADAPTIVE,
    ) -> None:
        self.path = path
        self.chain = Chain(load, kf_kind=kf_kind)
        self._writer = CaptureWriter(path)
        self._writer.begin(METADATA)

    def say(self, message) -> None:
        self.put(self.chain.frame(message))

    def put(self, wire: bytes) -> None:
        self._writer.append(self.chain.device_us / 1e6 + 0.2, wire)

    def hello(self, *, points: bool = True) -> "CaptureMaker":
        """HELLO, and the calibration's points as `terazi log` asks for them."""
        self.say(self.chain.hello())
        for point in self.chain.points if points else []:
            self.say(point)
        return self

    def samples(
        self,
        count: int,
        *,
        drop: Callable[[int], bool] = lambda index: False,
        change: Callable = lambda index, sample: sample,
        skip: int = 0,
        restart: bool = False,
        events: bool = False,
    ) -> "CaptureMaker":
        """count samples. skip: conversions lost before the first; restart: primed anew there;
        events: WEIGHT and STEP come too.
        """
        for index in range(count):
            first = index == 0
            sample = self.chain.sample(restart=restart and first, skip=skip if first else 0)
            wire = self.chain.frame(change(index, sample))
            if not drop(index):
                self.put(wire)
            for message, device_us in self.chain.unasked() if events else []:
                self.put(self.chain.frame(message, device_us))
            if self.chain.conversion % round(RATE_HZ) == 0:
                self.say(self.chain.status())
        return self

    def settings(self, **changed: int) -> "CaptureMaker":
        """Every SETTING, as `terazi log` asks for them; changed: by key's name."""
        for setting in SETTINGS:
            key = SettingKey(setting.key)
            self.say(Setting(key, changed.get(key.name.lower(), setting.default)))
        return self

    def imu(
        self,
        imu: FakeImu,
        count: int,
        *,
        drop: Callable[[object], bool] = lambda message: False,
        change: Callable = lambda message: message,
        lost: dict[int, int] | None = None,
    ) -> "CaptureMaker":
        """count samples of an IMU. drop: messages that do not arrive; lost: by the place of a
        sample, how many the device itself missed before it.
        """
        for index in range(count):
            for message in imu.sample(lost=(lost or {}).get(index, 0)):
                wire = self.chain.frame(change(message), imu.device_us)
                if not drop(message):
                    self.put(wire)
            if imu.number % imu.rate_hz == 0:
                self.put(self.chain.frame(imu.status(), imu.device_us))
        return self

    def tare(self, *, lose_ack: bool = False) -> "CaptureMaker":
        """A tare command and its ACK."""

        class Command:
            id, sequence, payload = Tare.ID, 0, b""

        wire = self.chain.answer(Command, mask=[3])
        if not lose_ack:
            self.put(wire)
        return self

    def another_chain(self, order: ChainOrder, kf_kind: KfKind) -> "CaptureMaker":
        """The filters' order and the Kalman filter are others from here on, and told."""
        self.chain.order, self.chain.kf_kind = order, kf_kind
        self.say(self.chain.hello())
        return self

    def calibrated(self, points: list, *, told: bool = True) -> "CaptureMaker":
        """Other points, (counts, gram), hold from here on: the ACK, and them if they are told."""
        self.chain.calibrate(scale_design.config(points))
        self.say(Ack(command=CalibrateEnd.ID, command_sequence=0, result=Result.OK))
        for point in self.chain.points if told else []:
            self.say(point)
        return self

    def end(self) -> Path:
        self._writer.close(self.chain.device_us / 1e6 + 0.3)
        return self.path
