# SPDX-License-Identifier: MIT
"""A test double of the device's IMU: what lies, turns and lies again, as messages.

Its motion is a script and its noise has a fixed seed. The attitude is that of the firmware's own C;
what the firmware itself makes of a part on a bus is tested on the bench (hil_tests).
"""

import math
import random
from dataclasses import dataclass, field

import numpy as np

from terazi.cshared import ImuCal, ImuTurn, Mahony, Rest, Zupt, ZuptGru
from terazi.cshared.imu import AT_REST, BIAS_KNOWN
from terazi.link.generated.messages import (
    Attitude,
    AttitudeFlag,
    Imu,
    ImuState,
    ImuStatus,
    Mag,
    MagKind,
)
from terazi.replay.attitude import still_detector

RATE_HZ = 500
WHO_AM_I = 0x68
BIAS_COUNTS = (25, -14, 8)
TURN_BEGIN_S, TURN_END_S, TURN_DEG_S = 3.0, 5.0, 45.0
UPRIGHT = 8  # px_py
LOST = 65535
RATED = ("500hz", "1000hz")  # 100 Hz has no detector
FIELD_COUNTS = (1200, 10, -2400)
ONE_G_COUNTS, COUNTS_PER_DEG_S = 2048, 16.384


@dataclass
class FakeImu:
    """One sample a call.

    every : as the setting imu.every;  mag_every : samples a field, 0: none.
    acc, gyro, mag : calibrations;  orientation : of part and magnetometer.
    """

    every: int = 5
    mag_every: int = 0
    identity: int = WHO_AM_I
    rate_hz: int = RATE_HZ
    number: int = 0  # of the sample, as on the wire
    missed: int = 0
    state: ImuState = ImuState.RUNNING
    acc: ImuCal = field(default_factory=ImuCal)
    gyro: ImuCal = field(default_factory=ImuCal)
    mag: ImuCal = field(default_factory=ImuCal)
    orientation: int = UPRIGHT
    detector: str = "shoe"
    begun_us: int = 0  # when sample 0 would have been
    _noise: random.Random = field(default_factory=lambda: random.Random(11))
    _mahony: Mahony | None = None
    _rest: Rest | None = None
    _zupt: Zupt | ZuptGru | None = None
    _field: tuple[int, int, int] | None = None
    _flags: int = 0  # AttitudeFlag since the last ATTITUDE

    @property
    def device_us(self) -> int:
        """When the latest sample was ready."""
        return self.begun_us + round(self.number / self.rate_hz * 1e6)

    def _measured(self) -> tuple[list[int], list[int]]:
        """A board that lies level, is turned about its x axis, and lies as it was left."""
        t_s = self.device_us / 1e6
        turned_s = min(max(t_s - TURN_BEGIN_S, 0.0), TURN_END_S - TURN_BEGIN_S)
        angle = math.radians(TURN_DEG_S * turned_s)
        rate = TURN_DEG_S if TURN_BEGIN_S < t_s < TURN_END_S else 0.0
        acc = [0.0, ONE_G_COUNTS * math.sin(angle), ONE_G_COUNTS * math.cos(angle)]
        gyro = [rate * COUNTS_PER_DEG_S, 0.0, 0.0]
        noisy = [round(value + self._noise.gauss(0.0, 3.0)) for value in (*acc, *gyro)]
        return noisy[:3], [one + bias for one, bias in zip(noisy[3:], BIAS_COUNTS, strict=True)]

    def begin_anew(self) -> None:
        """As where a setting of the chain is changed: all is forgotten but the field."""
        self.begun_us, self.number = self.device_us, 0
        self._mahony = self._rest = None

    def go_away(self, seconds: float) -> None:
        """The part does not answer for so long; its samples are not counted meanwhile."""
        self.begun_us += round(seconds * 1e6)
        self._gap(LOST)

    def _gap(self, lost: int) -> None:
        self._mahony.gap(lost)
        self._rest.interrupt()
        if self._zupt is not None:
            self._zupt.interrupt()
        self._flags |= AttitudeFlag.RESTARTED if lost == LOST else AttitudeFlag.GAP

    def _begin(self) -> None:
        rate = f"{self.rate_hz}hz"
        self._mahony, self._rest = Mahony(rate), Rest(rate)
        self._zupt = still_detector(self.detector if rate in RATED else "off", rate)
        self._gap(LOST)

    def sample(self, *, lost: int = 0) -> list:
        """The next sample after `lost` ones that the device itself missed: its messages."""
        self.number += 1 + lost
        self.missed += lost
        raw_acc, raw_gyro = self._measured()
        turn = ImuTurn(self.orientation).apply
        acc, gyro = turn(self.acc.apply(raw_acc)), turn(self.gyro.apply(raw_gyro))
        if self._mahony is None:
            self._begin()
        elif lost:
            self._gap(lost)
        rested = self._rest.update(gyro, acc)
        self._mahony.update(gyro, acc, self._rest.bias_q16)
        told: list = []
        if self.mag_every and self.number % self.mag_every == 0:
            self._field = turn(self.mag.apply(FIELD_COUNTS))
            told.append(Mag(self.number % 65536, *FIELD_COUNTS))
        if self._field is not None:
            self._mahony.update_mag(self._field)
        is_still = self._zupt is not None and self._zupt.update(gyro, acc)
        if self.number % self.every == 0:
            told.insert(0, Imu(self.number % 65536, *raw_acc, -11_000, *raw_gyro))
            told.append(self._attitude(rested, is_still))
            self._flags = 0
        return told

    def lose_magnetometer(self) -> None:
        """No field is used any more."""
        self._field, self.mag_every = None, 0

    def _attitude(self, rested: int, is_still: bool) -> Attitude:
        flags = int(self._flags)
        flags |= AttitudeFlag.REST if rested & AT_REST else 0
        flags |= AttitudeFlag.BIAS_KNOWN if rested & BIAS_KNOWN else 0
        flags |= AttitudeFlag.STILL if is_still else 0
        flags |= AttitudeFlag.HEADING if self._field is not None else 0
        return Attitude(self.number % 65536, *self._mahony.state_q30, AttitudeFlag(flags))

    def status(self) -> ImuStatus:
        counts = self._mahony.counts if self._mahony else dict.fromkeys(("gaps", "railed"), 0)
        bias = self._rest.bias_q16 if self._rest else (0, 0, 0)
        up = np.round(np.array(self._up()) * 2**14).astype(int).tolist()
        zeros = ("overruns", "losses", "clipped", "rest_rejected", "bus_recoveries")
        return ImuStatus(
            state=self.state,
            identity=self.identity,
            mag_kind=MagKind.QMC5883L if self.mag_every else MagKind.NONE,
            samples=max(self.number - self.missed, 0),
            missed=self.missed,
            temp_counts=-11_000,
            **{f"bias_{axis}_q16": value for axis, value in zip("xyz", bias, strict=True)},
            **{f"up_{axis}_q14": value for axis, value in zip("xyz", up, strict=True)},
            **dict.fromkeys(zeros, 0),
            **{name: counts.get(name, 0) for name in COUNTED},
        )

    def _up(self) -> tuple[float, float, float]:
        if self._mahony is None:
            return 0.0, 0.0, 1.0
        w, x, y, z = self._mahony.quat_wb
        return 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


COUNTED = ("acc_zero", "railed", "mag_refused", "mag_disturbed", "gaps")
