# SPDX-License-Identifier: MIT
"""A capture of the product's own (`terazi log --imu`) as a walk.

Samples are calibrated by the settings that the capture tells, with the device's own arithmetic, and
numbered by the device; its clock says how long a sample lasts. Samples that are missing lie on
straight lines. Where many are missing at once nobody knows where the foot went meanwhile: the
longest stretch without such a hole is read. Beside the samples lies what the device said of zero
velocity.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from terazi import units
from terazi.applications.walks.checks import RATES_HZ
from terazi.applications.walks.record import Device, Walk
from terazi.cshared.zupt import ZUPT_DETECTORS
from terazi.errors import CannotRead
from terazi.link.generated.messages import AttitudeFlag
from terazi.link.load import imu_advice
from terazi.recorder import Recording, load_recording
from terazi.recorder.capture import MAGIC
from terazi.recorder.inertial import counts_of, numbered
from terazi.replay.attitude import OFF, ZUPT_NAMES, calibrated
from terazi.replay.attitude_runs import are_told, settings_at

HOLE_S = 0.1  # more is a hole: a fifth of a swing
HOLE_SAMPLES = 8  # where samples are rare
MISSING_MOST = 0.05
LEFT_OUT_S = 1.0  # more than a start is told
RATE_WANTED_HZ = 190.0  # below, a foot strike's shock falls between the samples
RAIL_COUNTS = 32767
UNTOLD = 0.01  # of the samples may lack an ATTITUDE without a word
LATE_S = 0.030  # of the chip's classical detectors: `python -m tools.tune.zupt` prints it
ZUPT = "imu.zupt"
UNKNOWN = "unknown"
HOW = "`terazi set imu.every=1 uart.baud=500000`, then `terazi log --imu -o FILE`, records them."


def is_capture(path: Path) -> bool:
    """Whether a file begins as captures do, whatever its name."""
    try:
        with path.open("rb") as stream:
            return stream.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


def read_capture(path: Path) -> Walk:
    """Read one file; the walk is not checked yet. Raises CannotRead."""
    recording = load_recording(path, needs_samples=False)
    whole = recording.inertial.imu
    if len(whole["order"]) < 2:
        raise CannotRead(f"{path}: holds no samples of an IMU", remedy=_how_to_record(recording))
    notes: list[str] = []
    imu = _longest(whole, notes)
    values = settings_at(recording.inertial, int(imu["order"][0]))
    number = numbered(imu["sample"], imu["device_us"])
    every = int(np.median(np.diff(number)))
    grid = np.arange(number[0], number[-1] + 1, every)
    period_s = units.s_from_us(float(imu["device_us"][-1] - imu["device_us"][0])) / number[-1]
    _tell_rate(path, 1 / (every * period_s), every, notes)
    _tell_missing(recording, values, number, grid, period_s, notes)
    _tell_rails(imu, notes)
    acc, gyro = (_at(grid, number, each) for each in _measured(path, imu, values, notes))
    grid_us = _at(grid, number, imu["device_us"][:, None])[:, 0]
    device = _device(recording, imu, values, grid_us, notes)
    return Walk(
        path.stem,
        grid * period_s,
        units.m_s2_from_counts(acc),
        np.radians(units.deg_s_from_counts(gyro)),
        notes=tuple(notes),
        device=device,
    )


def _how_to_record(recording: Recording) -> str:
    values = settings_at(recording.inertial, 0)
    if not are_told(values):
        return HOW
    return " ".join([*(each for each in imu_advice(values, None) if "imu.mode" in each), HOW])


def _longest(imu: dict[str, np.ndarray], notes: list[str]) -> dict[str, np.ndarray]:
    """The stretch that lasts longest without a hole and without a start of the device."""
    us, boot = imu["device_us"], imu["boot"]
    steps_us, same = np.diff(us), np.diff(boot) == 0
    usual_us = float(np.median(steps_us[same])) if same.any() else 0.0
    hole_us = max(HOLE_S * units.US_PER_S, HOLE_SAMPLES * usual_us)
    cuts = np.flatnonzero(~same | (steps_us <= 0) | (steps_us > hole_us)) + 1
    edges = np.concatenate([[0], cuts, [len(us)]])
    lasts_us = us[edges[1:] - 1] - us[edges[:-1]]
    best = int(np.argmax(lasts_us))
    begin, end = edges[best], edges[best + 1]
    left_out_s = units.s_from_us(float(lasts_us.sum() - lasts_us[best]))
    if left_out_s > LEFT_OUT_S:
        from_s, to_s = imu["host_s"][begin], imu["host_s"][end - 1]
        notes.append(
            f"of {len(cuts) + 1} stretches between holes the longest is read, from {from_s:.1f} s "
            f"to {to_s:.1f} s of the capture: {left_out_s:.1f} s are left out"
        )
    return {name: column[begin:end] for name, column in imu.items()}


def _at(grid: np.ndarray, number: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(m, k) at the numbers of `grid`; what is missing lies on straight lines."""
    return np.column_stack([np.interp(grid, number, column) for column in values.T])


def _measured(
    path: Path, imu: dict[str, np.ndarray], values: Mapping[str, int], notes: list[str]
) -> list[np.ndarray]:
    """Acceleration and rate, (n, 3) counts each."""
    sensors = ("acc", "gyro")
    if not are_told(values):
        notes.append("no SETTING tells a calibration: the samples are taken as they are")
        return [counts_of(imu, f"{sensor}_") for sensor in sensors]
    try:
        return [calibrated(counts_of(imu, f"{each}_"), values, each, "imu") for each in sensors]
    except ValueError as error:
        raise CannotRead(f"{path}: its settings are none of a device: {error}") from None


def _tell_rate(path: Path, rate_hz: float, every: int, notes: list[str]) -> None:
    remedy = "`terazi set imu.every=1 uart.baud=500000` lets all samples be recorded."
    if rate_hz < RATES_HZ[0]:
        raise CannotRead(
            f"{path}: one in {every} samples was recorded, {rate_hz:.3g} a second; a walk needs "
            f"{RATES_HZ[0]:g} at least",
            remedy=remedy,
        )
    if rate_hz < RATE_WANTED_HZ:
        notes.append(f"one in {every} samples was recorded, {rate_hz:.0f} a second: {remedy}")


def _tell_missing(
    recording: Recording,
    values: Mapping[str, int],
    number: np.ndarray,
    grid: np.ndarray,
    period_s: float,
    notes: list[str],
) -> None:
    lost = len(grid) - len(number)
    if lost <= 0:
        return
    if lost > MISSING_MOST * len(grid):
        baud = recording.metadata.get("baud")
        told = are_told(values) and isinstance(baud, int)
        advice = [each for each in imu_advice(values, baud) if "baud" in each] if told else []
        raise CannotRead(
            f"{recording.path}: {lost} of {len(grid)} samples are missing; a walk can do without "
            f"{100 * MISSING_MOST:g} %",
            remedy=" ".join(advice) or "`terazi info` counts what is lost, and where.",
        )
    steps = np.diff(number)
    widest = int(np.argmax(steps))
    notes.append(
        f"{lost} of {len(grid)} samples are missing, at most {steps[widest] * period_s:.3f} s at a "
        f"time, at {number[widest] * period_s:.2f} s: straight lines lie there"
    )


def _tell_rails(imu: dict[str, np.ndarray], notes: list[str]) -> None:
    rails = (
        ("acc", "16 g", "is missing in the path"),
        ("gyro", "2000 deg/s", "is guessed at best"),
    )
    for sensor, limit, then in rails:
        counts = np.abs(counts_of(imu, f"{sensor}_").astype(np.int32))
        railed = int(np.sum((counts >= RAIL_COUNTS).any(axis=1)))
        if railed:
            notes.append(
                f"{railed} samples are beyond {limit}, the sensor's range: what was cut off there "
                f"{then}"
            )


def _device(
    recording: Recording,
    imu: dict[str, np.ndarray],
    values: Mapping[str, int],
    grid_us: np.ndarray,
    notes: list[str],
) -> Device:
    """What ATTITUDE said at each sample; where one is missing, as the one before."""
    name = ZUPT_NAMES.get(values.get(ZUPT, -1), UNKNOWN)
    attitude = recording.inertial.attitude
    mine = attitude["boot"] == imu["boot"][0]
    us, flags = attitude["device_us"][mine], attitude["flags"][mine]
    if name == OFF:
        return Device(name, None, why=f"{ZUPT} was {OFF}; `terazi set {ZUPT}=...` chooses another")
    at = np.searchsorted(us, grid_us + 1.0, side="right") - 1  # + 1: between samples, rounding
    if not len(us) or at[-1] < 0:
        return Device(name, None, why="no ATTITUDE was streamed; `terazi log` asks for them")
    still = (at >= 0) & (flags[np.clip(at, 0, None)] & int(AttitudeFlag.STILL) != 0)
    count = len(imu["device_us"])
    untold = count - int(np.isin(imu["device_us"], us).sum())
    if untold > UNTOLD * count:
        notes.append(
            f"{untold} of {count} samples lack their ATTITUDE: to the detector `device` they are "
            "what the one before said"
        )
    return Device(name, still, LATE_S if name in ZUPT_DETECTORS else 0.0)
