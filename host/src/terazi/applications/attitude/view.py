# SPDX-License-Identifier: MIT
"""A recording as attitudes over time, with what goes with them: rates, bias, rest, field, truth.

Of a capture these are the device's own ATTITUDE messages; of raw samples alone the shipped
fixed-point chain makes them here, uncalibrated unless the capture tells the settings.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from terazi import rotation, units
from terazi.applications.attitude.calibrated import measured, told_settings
from terazi.applications.attitude.records import Record, load_npz, of_inertial
from terazi.applications.attitude.score import (
    Errors,
    attitude_errors,
    error_quaternions,
    without_heading_offset,
)
from terazi.applications.attitude.trials import MAG_COUNTS_PER_UT
from terazi.cshared import ImuCal, ImuTurn, Mahony, Rest, Zupt
from terazi.cshared.imu import AT_REST, BIAS_KNOWN
from terazi.design import mahony as mahony_design
from terazi.design import rest as rest_design
from terazi.design import zupt as zupt_design
from terazi.errors import CannotRead, UsageError
from terazi.link.generated.messages import AttitudeFlag, ImuStatus, MagKind
from terazi.recorder import load_recording
from terazi.recorder.inertial import quats_of
from terazi.recorder.recording import Recording

MODES = (6, 9)
DETECTOR = "shoe"  # as the device leaves the factory
FLAGS = tuple(flag.name.lower() for flag in AttitudeFlag)
MAG_COUNTS_UT = {MagKind.QMC5883L: 30.0, MagKind.HMC5883L: 10.9}  # 3000 and 1090 a gauss


@dataclass
class Sensors:
    """What was measured, in body axes."""

    t_s: np.ndarray  # (m,)
    rate_b_deg_s: np.ndarray  # (m, 3), bias included
    acc_b_g: np.ndarray  # (m, 3)
    mag_b_ut: np.ndarray | None  # (m, 3)


@dataclass
class View:
    """Attitudes, (n,) each, over seconds since the first."""

    name: str
    source: str  # whose attitudes these are, in words
    rate_hz: float
    t_s: np.ndarray
    quat_wb: np.ndarray  # (n, 4) unit, scalar first
    flags: dict[str, np.ndarray]  # of FLAGS those that are known, (n,) bool
    bias_t_s: np.ndarray  # (k,)
    bias_deg_s: np.ndarray  # (k, 3)
    sensors: Sensors | None = None
    errors: Errors | None = None  # over samples that move and have a truth
    error_deg: dict[str, np.ndarray] = field(default_factory=dict)  # (n,) each, NaN where unknown
    heading_is_free: bool = True
    status: ImuStatus | None = None
    notes: list[str] = field(default_factory=list)

    @property
    def euler_deg(self) -> np.ndarray:
        """(n, 3) roll, pitch, yaw."""
        return rotation.euler_deg(self.quat_wb)

    @property
    def tilt_deg(self) -> np.ndarray:
        """(n,) how far body z stands off the vertical."""
        return rotation.tilt_deg(self.quat_wb)

    @property
    def rate_of_quat_deg_s(self) -> np.ndarray:
        """(n - 1, 3) turn rates of the attitude itself, body axes."""
        a, b = self.quat_wb[:-1], self.quat_wb[1:]
        scalar = np.sum(a * b, axis=1)
        vector = a[:, :1] * b[:, 1:] - b[:, :1] * a[:, 1:] - np.cross(a[:, 1:], b[:, 1:])
        vector *= np.where(scalar < 0, -1.0, 1.0)[:, None]
        sine = np.linalg.norm(vector, axis=1)
        angle = 2 * np.arctan2(sine, np.abs(scalar))
        share = np.divide(angle, sine, out=np.full_like(sine, 2.0), where=sine > 1e-12)
        return np.degrees(vector * (share / np.diff(self.t_s))[:, None])

    @property
    def rate_most_deg_s(self) -> float:
        """The fastest turn about an axis: as measured, or else of the attitude itself, but where
        it jumps because its inclination is being set."""
        if self.sensors is not None and len(self.sensors.rate_b_deg_s):
            return float(np.abs(self.sensors.rate_b_deg_s).max())
        jumps = self.flags.get("restarted", np.zeros(len(self.t_s), bool))
        rates = self.rate_of_quat_deg_s[~(jumps[:-1] | jumps[1:])]
        return float(np.abs(rates).max(initial=0.0))

    def share(self, flag: str) -> float | None:
        """Of the time that a flag held; None: not known."""
        return float(self.flags[flag].mean()) if flag in self.flags else None


def load_view(path: Path, *, mode: int | None = None) -> View:
    """A capture, or an .npz of trials.py's format. Raises CannotRead.

    mode : 6 or 9 axes where attitudes are made here; None: 6.
    """
    if path.suffix == ".npz":
        return of_record(load_npz(path), mode=mode or 6)
    recording = load_recording(path, needs_samples=False)
    if len(recording.inertial.attitude["order"]):
        if mode is not None:
            raise UsageError(
                f"{path.name} holds the device's own attitudes: --mode is for raw samples"
            )
        return of_device(recording)
    if not len(recording.inertial.imu["order"]):
        raise CannotRead(
            f"{path.name} holds neither ATTITUDE nor IMU messages",
            remedy="Record with an IMU on the board: terazi log --imu.",
        )
    return of_raw(recording, mode or 6)


def of_device(recording: Recording) -> View:
    """The device's own attitudes: of its longest run."""
    columns = recording.inertial.attitude
    boots, counts = np.unique(columns["boot"], return_counts=True)
    run = boots[np.argmax(counts)]
    mine = columns["boot"] == run
    quats = quats_of({name: column[mine] for name, column in columns.items()})
    us, bits = columns["device_us"][mine], columns["flags"][mine]
    known = np.linalg.norm(quats, axis=1) > 0
    if known.sum() < 2:
        raise CannotRead(f"{recording.path.name} holds {known.sum()} attitudes")
    quats, us, bits = quats[known], us[known], bits[known]
    notes = []
    if len(boots) > 1:
        notes.append(f"the device started {len(boots)} times: shown is the longest run")
    t_s = units.s_from_us((us - us[0]).astype(np.float64))
    statuses = [one for _at, one in recording.of_kind(ImuStatus) if one.boot == run]
    bias_q16 = [[getattr(s.message, f"bias_{axis}_q16") for axis in "xyz"] for s in statuses]
    sensors = None
    if np.any(recording.inertial.imu["boot"] == run):
        sensors = _calibrated(recording, int(us[0]), notes)
    return View(
        name=recording.path.name,
        source="the device's own",
        rate_hz=(len(t_s) - 1) / t_s[-1],
        t_s=t_s,
        quat_wb=rotation.unit(quats),
        flags={flag.name.lower(): bits & int(flag) != 0 for flag in AttitudeFlag},
        bias_t_s=np.array([units.s_from_us(s.device_us - int(us[0])) for s in statuses]),
        bias_deg_s=units.deg_s_from_counts(np.reshape(bias_q16, (-1, 3)) / 65536),
        sensors=sensors,
        status=statuses[-1].message if statuses else None,
        notes=notes,
    )


def _calibrated(recording: Recording, origin_us: int, notes: list[str]) -> Sensors:
    """Raw samples by the calibration that the capture tells; else as they are."""
    record, turned = _in_body_axes(recording, notes)
    imu = recording.inertial.imu
    boots, counts = np.unique(imu["boot"], return_counts=True)
    us = imu["device_us"][imu["boot"] == boots[np.argmax(counts)]]
    sensors = _sensors(record, *turned)
    sensors.t_s = units.s_from_us((us - origin_us).astype(np.float64))
    return sensors


def _in_body_axes(recording: Recording, notes: list[str]) -> tuple[Record, tuple]:
    """The record, and (gyro, acc, mag or None) calibrated and turned, int16; mag's counts a uT."""
    record = of_inertial(recording.inertial, recording.path.name)
    values = told_settings(recording.inertial)
    gyro, acc, mag = record.gyro_b_counts, record.acc_b_counts, record.mag_b_counts
    if values is not None:
        turn, mag_turn = (ImuTurn(values[f"{name}.orientation"]) for name in ("imu", "mag"))
        gyro, acc = (
            turn.block(measured("gyro", values, gyro)),
            turn.block(measured("acc", values, acc)),
        )
        if mag is not None:
            mag = mag_turn.block(measured("mag", values, mag))
    else:
        notes.append("no SETTING tells its calibration: raw samples are shown as they are")
    statuses = recording.of_kind(ImuStatus)
    kind = statuses[-1][1].message.mag_kind if statuses else MagKind.NONE
    return record, (gyro, acc, mag, MAG_COUNTS_UT.get(kind, MAG_COUNTS_PER_UT))


def of_raw(recording: Recording, mode: int) -> View:
    """Raw samples of a capture through the shipped chain."""
    notes: list[str] = []
    record, (gyro, acc, mag, counts_ut) = _in_body_axes(recording, notes)
    if len(record.whole_stretches()) > 1:
        notes.append("samples are missing: the filter runs on as if they were not")
    return _through_chain(record, gyro, acc, mag, mode, counts_ut, notes)


def of_record(record: Record, *, mode: int = 6) -> View:
    """An .npz through the shipped chain, its sensors taken as calibrated."""
    blocks = [
        None if raw is None else ImuCal().block(raw)
        for raw in (record.gyro_b_counts, record.acc_b_counts, record.mag_b_counts)
    ]
    return _through_chain(record, *blocks, mode, MAG_COUNTS_PER_UT, [])


def _through_chain(record, gyro, acc, mag, mode: int, counts_ut: float, notes: list[str]) -> View:
    if mode not in MODES:
        raise UsageError(f"--mode is 6 or 9, not {mode}")
    if mode == 9 and mag is None:
        raise UsageError(f"{record.name} holds no magnetometer: six axes only")
    rate_hz = record.rate_hz
    rest_config = rest_design.config_at(rate_hz)
    changed = {} if counts_ut == MAG_COUNTS_PER_UT else {"mag_counts_per_ut": counts_ut}
    filtered = Mahony(mahony_design.config_at(rate_hz, **changed))
    fields = mag if mode == 9 else None
    quats_q30 = filtered.block(gyro, acc, fields, rest=Rest(rest_config))
    bias_q16, bits = Rest(rest_config).block(gyro, acc)
    still = Zupt(zupt_design.config_at(DETECTOR, rate_hz)).block(gyro, acc)
    quats = rotation.unit(quats_q30)
    view = View(
        name=record.name,
        source=f"computed here by the shipped filter, {mode} axes",
        rate_hz=rate_hz,
        t_s=record.t_s,
        quat_wb=quats,
        flags={
            "rest": bits & AT_REST != 0,
            "bias_known": bits & BIAS_KNOWN != 0,
            "still": still,
        },
        bias_t_s=record.t_s,
        bias_deg_s=units.deg_s_from_counts(bias_q16 / 65536),
        sensors=_sensors(record, gyro, acc, mag, counts_ut),
        heading_is_free=mode == 6,
        notes=notes,
    )
    _compare(view, record)
    return view


def _sensors(record: Record, gyro, acc, mag, counts_ut: float) -> Sensors:
    return Sensors(
        t_s=record.t_s,
        rate_b_deg_s=units.deg_s_from_counts(gyro.astype(np.float64)),
        acc_b_g=acc / units.ACC_COUNTS_PER_STANDARD_GRAVITY,
        mag_b_ut=None if mag is None else mag / counts_ut,
    )


def _compare(view: View, record: Record) -> None:
    """Errors against the truth, where the record has one."""
    if record.truth_wb is None:
        return
    known = np.isfinite(record.truth_wb).all(axis=1)
    if not known.any():
        return
    scored = known if record.moving is None else known & record.moving
    if scored.any():
        view.errors = attitude_errors(
            view.quat_wb[scored], record.truth_wb[scored], heading_is_free=view.heading_is_free
        )
    parts = error_quaternions(view.quat_wb[known], record.truth_wb[known])
    if view.heading_is_free:
        parts = without_heading_offset(parts)
    w, z = np.abs(parts[:, 0]), parts[:, 3] * np.sign(parts[:, 0])
    level = np.hypot(parts[:, 1], parts[:, 2])
    for name, value in (
        ("inclination", 2 * np.arctan2(level, np.hypot(w, z))),
        ("heading", 2 * np.arctan2(z, w)),
    ):
        column = np.full(len(known), np.nan)
        column[known] = np.degrees(value)
        view.error_deg[name] = column
