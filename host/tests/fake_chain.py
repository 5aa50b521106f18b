# SPDX-License-Identifier: MIT
"""A test double of the device: what it makes of conversions and of commands, as frames.

It is no firmware and knows no converter, no faults of a cable and no checkweigher; the genuine
firmware runs on the bench (hil_tests). Filters and scale are the firmware's own C; settings,
calibration and EEPROM behave as shared_c/spec says, so that the host's dialogues can be tested.
"""

import dataclasses
import random
from collections.abc import Callable

from host.tests.fake_commands import Commands
from host.tests.fake_imu import FakeImu
from terazi.cshared import Fir, Scale, ScaleFlag, WeightKf, WeightKfAdaptive, encode_frame
from terazi.design import scale as scale_design
from terazi.link.generated.messages import (
    FINGERPRINT,
    Attitude,
    ChainOrder,
    ConverterState,
    Fault,
    FaultFlag,
    Hello,
    Imu,
    ImuStatus,
    KfKind,
    Mag,
    Point,
    ResetCause,
    Sample,
    SampleFlag,
    Status,
    Step,
    StreamFlag,
    Weight,
)
from terazi.units import COUNTS_RAIL_HIGH, COUNTS_RAIL_LOW

RATE_HZ = 82.0
WEIGHT_EVERY_US = 100_000
EMPTY_COUNTS = 84_000
COUNTS_PER_G = 214_775 / 500
TEMPERATURE_UNKNOWN = -(1 << 31)
FLAGS = {
    Sample: StreamFlag.SAMPLE,
    Status: StreamFlag.STATUS,
    ImuStatus: StreamFlag.STATUS,
    Weight: StreamFlag.WEIGHT,
    Attitude: StreamFlag.ATTITUDE,
    Imu: StreamFlag.IMU,
    Mag: StreamFlag.IMU,
}


def steps_and_noise(t_s: float) -> int:
    """A load that is put on at 2 s and taken off at 6 s, with noise from a fixed seed."""
    noise = random.Random(round(t_s * 1e6)).gauss(0.0, 40.0)
    load_counts = 214_775 if 2.0 <= t_s % 8.0 < 6.0 else 0  # 500 g
    return EMPTY_COUNTS + load_counts + round(noise)


class Chain(Commands):
    """What the device makes of a conversion: FIR, Kalman, scale; and the frames of it."""

    def __init__(
        self,
        load: Callable[[float], int] = steps_and_noise,
        *,
        kf_kind: KfKind = KfKind.ADAPTIVE,
        imu: FakeImu | None = None,
    ) -> None:
        self.load = load
        self.imu = imu
        self.fingerprint = FINGERPRINT
        self.sequence = 0
        self.conversion = 0
        self.samples = 0
        self.device_us = 0
        self.faults = self._told_faults = FaultFlag(0)
        self.temperature_centi = TEMPERATURE_UNKNOWN
        self.state = ConverterState.RUNNING
        self._fir: Fir | None = None
        self._kf: WeightKf | WeightKfAdaptive | None = None
        self._last_q7 = 0
        self._weight_flags = ScaleFlag(0)
        self._weight_us: int | None = None
        self.order, self.kf_kind = ChainOrder.FIR_KF, kf_kind
        super().__init__()
        self.calibrate(scale_design.config())

    def frame(self, message, device_us: int | None = None) -> bytes:
        """The frame of a message, numbered."""
        sequence, self.sequence = self.sequence, (self.sequence + 1) % 256
        us = self.device_us if device_us is None else device_us
        return encode_frame(message.ID, sequence, us % (1 << 32), message.pack())

    def hello(self) -> Hello:
        return Hello(
            protocol_fingerprint=self.fingerprint,
            version_major=0,
            version_minor=1,
            version_patch=0,
            build=0x1234ABCD,
            reset_cause=ResetCause.EXTERNAL,
            gain=128,
            fir_design=0,
            fir_taps=32,
            kf_schedule=0,
            converter_rate_hz_q16=0,
            chain_order=self.order,
            kf_kind=self.kf_kind,
        )

    def calibrate(self, config: dict) -> None:
        """Weigh by another configuration (scale.h); raises ScaleRefusedError."""
        scale = Scale(config)
        self.config = config
        columns = (config["point_counts_q7"], config["point_mass_mg"])
        pairs = list(zip(*columns, strict=True))[: config["points"]]
        self.points = [
            Point(at, counts_q7, mass_mg) for at, (counts_q7, mass_mg) in enumerate(pairs)
        ]
        self.scale = scale

    def status(self) -> Status:
        fields = {field.name: 0 for field in dataclasses.fields(Status)}
        fields |= {
            "uptime_s": self.device_us // 1_000_000,
            "converter_state": self.state,
            "converter_rate_hz_q16": round(RATE_HZ * 65536),
            "conversions": self.conversion,
            "stack_free_bytes": 1200,
            "cpu_busy_permille": 21,
            "faults": self.faults,
            "faults_seen": self.faults,
            "settings_state": self.settings_state,
            "settings_saved": self.eeprom.sequence,
        }
        return Status(**fields)

    def health(self) -> list:
        """STATUS, and what stands behind it."""
        return [self.status(), self.imu.status()] if self.imu else [self.status()]

    def sample(self, *, restart: bool = False, skip: int = 0) -> Sample:
        """The next conversion; restart primes the filters anew, skip loses some before it."""
        self.conversion += 1 + skip
        raw = self.load(self.conversion / RATE_HZ)
        self.device_us = round(self.conversion / RATE_HZ * 1e6)
        flags = SampleFlag.GAP if skip else SampleFlag(0)
        if raw in (COUNTS_RAIL_LOW, COUNTS_RAIL_HIGH):
            flags |= SampleFlag.AT_RAIL
        restart = restart or self._fir is None
        if restart:
            flags |= SampleFlag.RESTARTED
        if self.order == ChainOrder.FIR_KF:
            fir = self._run_fir(raw, restart)
            kf_q7 = self._last_q7 = self._run_kf(fir, restart)
        else:
            kf_q7 = self._run_kf(raw, restart)
            fir = self._run_fir((kf_q7 + 64) >> 7, restart)
            self._last_q7 = fir * 128
        self.samples += 1
        self._weight_flags = self.scale.update(self._last_q7, self.device_us % (1 << 32))
        return Sample(
            conversion=self.conversion % 65536,
            raw_counts=raw,
            fir_counts=fir,
            kf_counts_q7=kf_q7,
            mass_mg=self.scale.mass_mg,
            net_mg=self.scale.net_mg,
            flags=flags,
            weight_flags=int(self._weight_flags),
        )

    def wants(self, message) -> bool:
        """Whether the host has asked for messages of this kind."""
        return bool(self.mask & FLAGS.get(type(message), StreamFlag.EVENT))

    def unasked(self) -> list[tuple]:
        """(message, device_us) of what follows the latest sample: WEIGHT when due, and STEP; of
        the IMU what has come meanwhile."""
        told: list[tuple] = []
        while self.imu and self.imu.device_us + 1e6 / self.imu.rate_hz <= self.device_us:
            told += [(message, self.imu.device_us) for message in self.imu.sample()]
        flags = self._weight_flags
        if flags & ScaleFlag.STEPPED:
            step = Step(self.scale.step_from_mg, self.scale.step_to_mg, self.scale.steps)
            told.append((step, self.scale.step_us))
        due = self._weight_us is None or self.device_us - self._weight_us >= WEIGHT_EVERY_US
        if due or flags != self._told_flags:
            self._weight_us, self._told_flags = self.device_us, flags
            told.append((self.weight(), self.device_us))
        return told

    def weight(self) -> Weight:
        return Weight(
            net_mg=self.scale.net_mg,
            zero_mg=self.scale.zero_mg,
            tare_mg=self.scale.tare_mg,
            shown=self.scale.shown,
            unit=self.config["unit"],
            decimals=self.config["decimals"],
            weight_flags=int(self._weight_flags),
            pieces=self.scale.pieces,
            faults=self.faults,
            calibrating=0 if self.staged is None else len(self.staged) + 1,
            temperature_centi=self.temperature_centi,
        )

    @property
    def is_stable(self) -> bool:
        """Standing still; also where the load is beyond Max by the calibration that holds."""
        return bool(self.scale.steady) and not self.faults

    @property
    def last_counts_q7(self) -> int:
        """What the chain ended with."""
        return self._last_q7

    def prime(self) -> None:
        """The next sample begins the filters anew."""
        self._fir = None

    def _run_fir(self, counts: int, restart: bool) -> int:
        if restart:
            self._fir = Fir("lowpass32", counts)
        return self._fir.update(counts)

    def _run_kf(self, counts: int, restart: bool) -> int:
        if restart:
            kind = WeightKfAdaptive if self.kf_kind == KfKind.ADAPTIVE else WeightKf
            self._kf = kind("default", counts)
        return self._kf.update(counts)

    def fall_silent(self) -> None:
        """Time goes on by one conversion, but the converter has none."""
        self.state = ConverterState.TIMED_OUT
        self.faults |= FaultFlag.CABLE_OUT
        self.conversion += 1
        self.device_us = round(self.conversion / RATE_HZ * 1e6)

    def fault(self) -> Fault | None:
        """The change of faults since it was asked last."""
        changed, self._told_faults = self.faults ^ self._told_faults, self.faults
        return Fault(self.faults, changed) if changed else None
