# SPDX-License-Identifier: MIT
"""A board whose raw IMU samples are followed for a calibration; as before when it is over."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping

import numpy as np

from terazi.control.settings import apply_settings, read_settings
from terazi.errors import CalibrationRefused, NoAnswer, TeraziError
from terazi.link import Link
from terazi.link.generated.messages import Imu, ImuStatus, SetStream, StreamFlag
from terazi.link.generated.settings import SETTINGS_BY_NAME
from terazi.recorder.inertial import Inertial, InertialColumns, counts_of

FIRST_S = 3.0  # after a start it has answered by then, or there is none
SILENCE_S = 2.0
WIRING = "Wire one: VCC at 5V, GND, SDA at A4, SCL at A5. `terazi info` shows what answers."
MODES = dict(SETTINGS_BY_NAME["imu.mode"].choices)
RATE_HZ = 500.0  # of hz_500
QUIET = StreamFlag.STATUS | StreamFlag.EVENT


class ImuBoard:
    """A context manager: mode, every and stream are put back, by an exception too.

    every : one in so many samples is sent.
    """

    def __init__(self, link: Link, *, mode: str = "hz_500", every: int = 2) -> None:
        self.link = link
        self.rate_hz = RATE_HZ / every  # of a calibration's samples
        self.status: ImuStatus | None = None
        self._wanted = {"imu.mode": MODES[mode], "imu.every": every}
        self._before: dict[str, int] = {}
        self._columns = InertialColumns()
        self._given = 0
        self._mask = 0
        self._heard_s = 0.0

    def __enter__(self) -> ImuBoard:
        # Attitudes may fill the line, so that there is no room for answers.
        self.link.command(SetStream(mask=QUIET))
        self._before = read_settings(self.link, self._wanted)
        self._mask = read_settings(self.link, ["stream.mask"])["stream.mask"]
        try:
            self.set(self._wanted)
            self.link.command(SetStream(mask=QUIET | StreamFlag.IMU))
            self._want_imu()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_exception) -> None:
        with contextlib.suppress(TeraziError):  # the link may be what failed: a reset does it too
            self.link.command(SetStream(mask=QUIET))
            apply_settings(self.link, self._before)
            self.link.command(SetStream(mask=self._mask))

    def set(self, wanted: Mapping[str, int]) -> None:
        """Settings for now; what came before is forgotten."""
        apply_settings(self.link, wanted)
        self.forget()

    def forget(self) -> None:
        """Samples of before do not count."""
        self.resume()
        self._columns, self._given = InertialColumns(), 0

    def resume(self) -> None:
        """What came while nobody followed is lost; what was taken before stays."""
        self.link.fresh()
        self._heard_s = self.link.now_s()

    def _want_imu(self) -> None:
        end_s = self.link.now_s() + FIRST_S
        while not self._given and self.link.now_s() < end_s:
            self._take(0.1)
        if not self._given:
            raise CalibrationRefused(
                "the board has no IMU: nothing answers as an MPU-6050", remedy=WIRING
            )

    def follow(self, seconds: float) -> int:
        """Let time go by; gives how many samples there are by now. Raises NoAnswer."""
        end_s = self.link.now_s() + seconds
        while (left_s := end_s - self.link.now_s()) > 0:
            self._take(left_s)
        if self.link.now_s() - self._heard_s > SILENCE_S:
            raise NoAnswer(f"{self.link.name} sends no IMU samples any more", remedy=WIRING)
        return self._given

    def _take(self, seconds: float) -> None:
        for received in self.link.poll(seconds):
            if isinstance(received.message, ImuStatus):
                self.status = received.message
            if self._columns.take(received) and isinstance(received.message, Imu):
                self._given += 1
                self._heard_s = self.link.now_s()

    @property
    def inertial(self) -> Inertial:
        """All samples since they count."""
        return self._columns.to_inertial()

    def newest(self, first: int) -> tuple[np.ndarray, np.ndarray]:
        """Accelerations and rates from sample `first` on, (n, 3) counts each."""
        imu = {name: column[first:] for name, column in self.inertial.imu.items()}
        return counts_of(imu, "acc_"), counts_of(imu, "gyro_")
