# SPDX-License-Identifier: MIT
"""The attitude chain over the raw samples of a recording, compared bit for bit with ATTITUDE.

    imu_cal, gyroscope and accelerometer -> imu_cal_turn -> rest -> mahony -> each ATTITUDE
    imu_cal, magnetometer -> imu_cal_turn -> mahony_update_mag, with the newest field each sample

The filter's state is known from its start only, and as long as every sample was recorded: what lies
behind a frame that was lost, or in a recording begun in mid-stream, is named as not verified, with
the reason.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from terazi.cshared import ImuCal, ImuTurn, Mahony, Rest
from terazi.cshared.imu import AT_REST, BIAS_KNOWN
from terazi.link.generated.messages import AttitudeFlag, Setting
from terazi.link.generated.settings import SETTINGS
from terazi.recorder.inertial import Inertial, counts_of
from terazi.recorder.recording import Recording
from terazi.replay.stage import StageResult
from terazi.replay.unverified import Unverified

SAMPLE_PERIOD = 1 << 16
FIRST_SAMPLES = (0, 1)  # numbers of a device's first sample
GROUPS = ("imu", "acc", "gyro", "mag")  # of settings that the chain knows
NO_MATTER = ("imu.tilt_limit_mrad", "imu.lamp")
NOT_RECORDED = "its raw sample was not recorded"
RATES_HZ = {1: 500, 2: 1000}  # by imu.mode
COMPONENTS = ("quat_w_q30", "quat_x_q30", "quat_y_q30", "quat_z_q30")
KEYS = {one.key: one.full_name for one in SETTINGS if one.group in GROUPS}


@dataclass(frozen=True)
class Run:
    """Samples [begin, end) of the raw ones, from the start of the filter on, none missing.

    lost : by the place of a sample, how many the device itself missed before it.
    why : it ends where it does; "": with the recording.
    """

    begin: int
    end: int
    lost: Mapping[int, int] = field(default_factory=dict)
    why: str = ""


@dataclass
class Replayed:
    """What the chain answers here to the samples of a run: one row a sample."""

    quats_q30: np.ndarray  # (n, 4) int32
    flags: np.ndarray  # (n,) uint8: REST and BIAS_KNOWN as in ATTITUDE


def settings_of(inertial: Inertial) -> dict[str, int]:
    """Values by full name of what the chain is set to, as they were told first."""
    values: dict[str, int] = {}
    for _order, one in inertial.told:
        if isinstance(one.message, Setting) and one.message.key in KEYS:
            values.setdefault(KEYS[one.message.key], one.message.value)
    return values


def changed_at(inertial: Inertial, values: Mapping[str, int]) -> tuple[int, str] | None:
    """Where one of them is told to be another, and which; None where all stay."""
    for order, one in inertial.told:
        if isinstance(one.message, Setting) and one.message.key in KEYS:
            name = KEYS[one.message.key]
            if name not in NO_MATTER and values[name] != one.message.value:
                return order, name
    return None


def runs_of(inertial: Inertial) -> list[Run]:
    """One for each start of the device; empty ones say why nothing of it is known."""
    imu = inertial.imu
    runs = []
    for boot in np.unique(imu["boot"]).tolist():
        rows = np.flatnonzero(imu["boot"] == boot)
        begin, end = int(rows[0]), int(rows[-1]) + 1
        if int(imu["sample"][begin]) not in FIRST_SAMPLES:
            why = "recorded from mid-stream, the filter's state is unknown"
            runs.append(Run(begin, begin, why=why))
        else:
            runs.append(_whole(inertial, begin, end))
    return runs


def _whole(inertial: Inertial, begin: int, end: int) -> Run:
    """From begin to where a frame is missing."""
    imu, attitude = inertial.imu, inertial.attitude
    step = np.diff(imu["sample"][begin:end].astype(np.int64)) % SAMPLE_PERIOD
    was_lost = np.diff(imu["lost"][begin:end]) > 0
    gaps = attitude["device_us"][attitude["flags"] & int(AttitudeFlag.GAP) != 0]
    told_gap = np.isin(imu["device_us"][begin + 1 : end], gaps)
    missing = step != 1
    broken = np.flatnonzero(missing & (was_lost | ~told_gap))
    why = ""
    if len(broken):
        end = begin + 1 + int(broken[0])
        why = "frames were lost on the way, and the filter's state with them"
    at = begin + 1 + np.flatnonzero(missing)
    lost = {int(place): int(step[place - begin - 1]) - 1 for place in at if place < end}
    return Run(begin, end, lost, why)


def matrix_of(values: Mapping[str, int], sensor: str) -> list[list[int]]:
    """(3, 3) of imu_cal_config_t: what has no setting is zero (the accelerometer's upper part)."""
    names = [[f"{sensor}.{row}{column}_q16" for column in "xyz"] for row in "xyz"]
    return [[values.get(name, 0) for name in row] for row in names]


def calibration_of(values: Mapping[str, int], sensor: str) -> ImuCal:
    """What takes a sensor's offsets and misalignment off."""
    offset = [values[f"{sensor}.offset_q3_{axis}"] for axis in range(3)]
    return ImuCal(matrix_of(values, sensor), offset)


def replay_run(inertial: Inertial, run: Run, values: Mapping[str, int], rate_hz: int) -> Replayed:
    """The chain over one run.

    rate_hz : names the configurations of rest and mahony.
    """
    if run.begin == run.end:
        return Replayed(np.zeros((0, 4), np.int32), np.zeros(0, np.uint8))
    imu, place = inertial.imu, slice(run.begin, run.end)
    turn = ImuTurn(values["imu.orientation"])
    gyro, acc = (
        turn.block(calibration_of(values, sensor).block(counts_of(imu, f"{sensor}_")[place]))
        for sensor in ("gyro", "acc")
    )
    mag, mag_begin = _fields(inertial, run, values)
    rest, mahony = Rest(f"{rate_hz}hz", gyro[0], acc[0]), Mahony(f"{rate_hz}hz")
    quats, flags = [], []
    cuts = sorted({0, mag_begin, len(gyro), *(at - run.begin for at in run.lost)})
    for begin, end in pairwise(cuts):
        if lost := run.lost.get(run.begin + begin):
            mahony.gap(min(lost, SAMPLE_PERIOD - 1))
            rest.interrupt()
        part = slice(begin, end)
        bias_q16, rested = rest.block(gyro[part], acc[part])
        fields = mag[part] if begin >= mag_begin else None
        quats.append(mahony.block(gyro[part], acc[part], fields, bias_q16=bias_q16))
        flags.append(
            np.where(rested & AT_REST, int(AttitudeFlag.REST), 0)
            | np.where(rested & BIAS_KNOWN, int(AttitudeFlag.BIAS_KNOWN), 0)
        )
    return Replayed(np.concatenate(quats), np.concatenate(flags))


def _fields(inertial: Inertial, run: Run, values: Mapping[str, int]) -> tuple[np.ndarray, int]:
    """The newest field at each sample of a run, calibrated, and where the first one came."""
    count = run.end - run.begin
    mag, imu = inertial.mag, inertial.imu
    mine = np.flatnonzero(mag["boot"] == imu["boot"][run.begin])
    if not len(mine):
        return np.zeros((count, 3), np.int16), count
    turn = ImuTurn(values["mag.orientation"])
    fields = turn.block(calibration_of(values, "mag").block(counts_of(mag)[mine]))
    place = slice(run.begin, run.end)
    numbers = _unwrapped(imu["sample"][place])
    near = numbers[np.clip(np.searchsorted(imu["order"][place], mag["order"][mine]), 0, count - 1)]
    used_from = near + _signed(mag["sample"][mine].astype(np.int64) - near)
    newest = np.searchsorted(used_from, numbers, side="right") - 1
    return fields[np.clip(newest, 0, None)], int(np.searchsorted(newest, 0))


def _unwrapped(numbers: np.ndarray) -> np.ndarray:
    """Numbers of samples without the step back at SAMPLE_PERIOD."""
    numbers = numbers.astype(np.int64)
    return numbers[0] + np.concatenate([[0], np.cumsum(np.diff(numbers) % SAMPLE_PERIOD)])


def _signed(difference: np.ndarray) -> np.ndarray:
    """Modulo SAMPLE_PERIOD, the one that is nearest to zero."""
    half = SAMPLE_PERIOD // 2
    return (difference + half) % SAMPLE_PERIOD - half


# --- against what the device said ---


def compare_attitude(recording: Recording) -> tuple[list[StageResult], list[Unverified]]:
    """What the device's attitudes are against this host's; nothing where there are none."""
    inertial = recording.inertial
    count = len(inertial.attitude["sample"])
    if not count:
        return [], []
    stages = [StageResult("attitude"), StageResult("rest")]
    values = settings_of(inertial)
    if why := _why_none(inertial, values):
        return stages, [Unverified("attitude", count, why)]
    whys: Counter[str] = Counter()
    for run in runs_of(inertial):
        run = _until_changed(inertial, run, values)
        try:
            replayed = replay_run(inertial, run, values, RATES_HZ[values["imu.mode"]])
        except ValueError as error:  # settings that no device takes
            return stages, [Unverified("attitude", count, str(error))]
        whys += _compare_run(stages, inertial, run, replayed)
    known = stages[0].compared + whys.total()
    whys[NOT_RECORDED] += count - known
    return stages, [
        Unverified("attitude", samples, why) for why, samples in whys.items() if samples
    ]


def _why_none(inertial: Inertial, values: Mapping[str, int]) -> str:
    """Why nothing at all can be verified; "" where something can."""
    if not len(inertial.imu["sample"]):
        return "no raw sample was recorded; `terazi log --imu` does"
    if set(values) != set(KEYS.values()):
        return "no SETTING tells how the IMU was set; `terazi log` asks for them"
    if values["imu.every"] != 1:
        return f"one in {values['imu.every']} samples was recorded, and imu.every=1 is needed"
    if values["imu.mode"] not in RATES_HZ:
        return "imu.mode was none in which attitudes come"
    return ""


def _until_changed(inertial: Inertial, run: Run, values: Mapping[str, int]) -> Run:
    """The run, up to where a setting was changed."""
    change = changed_at(inertial, values)
    if change is None:
        return run
    order, name = change
    end = int(np.searchsorted(inertial.imu["order"], order))
    if end >= run.end:
        return run
    return replace(run, end=max(end, run.begin), why=f"{name} was changed while it was recorded")


def _compare_run(
    stages: list[StageResult], inertial: Inertial, run: Run, replayed: Replayed
) -> Counter[str]:
    """Compare the attitudes of a run; gives why some of its start of the device were not."""
    imu, attitude = inertial.imu, inertial.attitude
    boot = imu["boot"][min(run.begin, len(imu["boot"]) - 1)]
    mine = np.flatnonzero(attitude["boot"] == boot)
    ready_us = imu["device_us"][run.begin : run.end]
    us = attitude["device_us"][mine]
    place = np.searchsorted(ready_us, us)
    behind = place >= len(ready_us)
    place = np.clip(place, 0, max(len(ready_us) - 1, 0))
    found = ~behind & (ready_us[place] == us) if len(ready_us) else np.zeros(len(mine), bool)
    indices, place = mine[found], place[found]
    device = np.stack([attitude[name][indices] for name in COMPONENTS], axis=1)
    stages[0].add(attitude["sample"], indices, device, replayed.quats_q30[place])
    compared = AttitudeFlag.REST | AttitudeFlag.BIAS_KNOWN
    flags = attitude["flags"][indices] & int(compared)
    stages[1].add(attitude["sample"], indices, flags, replayed.flags[place])
    return Counter({run.why or NOT_RECORDED: int(behind.sum())})
