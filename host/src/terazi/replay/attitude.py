# SPDX-License-Identifier: MIT
"""The attitude chain over raw samples, in the order of the firmware's attitude.c.

    gyroscope, accelerometer -> imu_cal -> imu_cal_turn -> rest -> mahony_update -> zupt or zupt_gru
    magnetometer             -> imu_cal -> imu_cal_turn -> mahony_update_mag, the newest each sample

Which samples a recording holds without a hole, and what of the device's answers is compared with
these: attitude_runs.py and attitude_compare.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from terazi.cshared import ImuCal, ImuTurn, Mahony, Rest, Zupt, ZuptGru
from terazi.cshared.imu import AT_REST, BIAS_KNOWN
from terazi.link.generated.messages import AttitudeFlag
from terazi.link.generated.settings import SETTINGS_BY_NAME
from terazi.recorder.inertial import Inertial, counts_of
from terazi.replay.attitude_runs import LOST, Run, settings_at, told_flags

RATES_HZ = {1: 500, 2: 1000}  # by imu.mode
OFF = "off"
ZUPT_NAMES = {number: name for name, number in SETTINGS_BY_NAME["imu.zupt"].choices}


@dataclass
class Replayed:
    """What the chain answers here to the samples of a run: one row a sample."""

    quats_q30: np.ndarray  # (n, 4) int32
    flags: np.ndarray  # (n,) uint8: REST, BIAS_KNOWN and STILL as in ATTITUDE


class Chain:
    """The filters of one run, from their start on."""

    def __init__(self, values: Mapping[str, int]) -> None:
        """values : settings by full name; ValueError where no device would take them."""
        rate = f"{RATES_HZ[values['imu.mode']]}hz"
        self._mahony, self._rest = Mahony(rate), Rest(rate)
        self._zupt = still_detector(ZUPT_NAMES.get(values["imu.zupt"], OFF), rate)

    def gap(self, lost: int) -> None:
        """So many samples are missing before the next one; LOST: the IMU had been away."""
        self._mahony.gap(lost)
        self._rest.interrupt()
        if self._zupt is not None:
            self._zupt.interrupt()

    def block(
        self, gyro: np.ndarray, acc: np.ndarray, fields: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """(n, 3) samples, calibrated, in the board's axes; gives quaternions and flags."""
        bias_q16, rested = self._rest.block(gyro, acc)
        quats_q30 = self._mahony.block(gyro, acc, fields, bias_q16=bias_q16, as_state=True)
        flags = np.where(rested & AT_REST, int(AttitudeFlag.REST), 0)
        flags |= np.where(rested & BIAS_KNOWN, int(AttitudeFlag.BIAS_KNOWN), 0)
        if self._zupt is not None:
            flags |= np.where(self._zupt.block(gyro, acc), int(AttitudeFlag.STILL), 0)
        return quats_q30, flags.astype(np.uint8)


def still_detector(name: str, rate: str) -> Zupt | ZuptGru | None:
    """What a device runs whose imu.zupt is `name`, fresh; `rate` is 500hz or 1000hz."""
    if name == OFF:
        return None
    return ZuptGru(1000 // int(rate.removesuffix("hz"))) if name == "gru" else Zupt(name, rate)


def replay_run(inertial: Inertial, run: Run, values: Mapping[str, int]) -> Replayed:
    """The chain over one run. ValueError: settings that no device would take."""
    chain = Chain(values)
    place = slice(run.begin, run.end)
    gyro, acc = (
        calibrated(counts_of(inertial.imu, f"{sensor}_")[place], values, sensor, "imu")
        for sensor in ("gyro", "acc")
    )
    fields, is_used = _fields(inertial, run, values)
    turns = np.flatnonzero(np.diff(is_used)) + 1  # where the magnetometer comes or goes
    gaps = {at - run.begin: lost for at, lost in run.lost.items()} | {0: LOST}
    cuts = sorted({0, len(gyro), *turns.tolist(), *gaps})
    quats, flags = [np.zeros((0, 4), np.int32)], [np.zeros(0, np.uint8)]
    for begin, end in pairwise(cuts):
        if begin in gaps:
            chain.gap(gaps[begin])
        part = slice(begin, end)
        answers = chain.block(gyro[part], acc[part], fields[part] if is_used[begin] else None)
        quats.append(answers[0])
        flags.append(answers[1])
    return Replayed(np.concatenate(quats), np.concatenate(flags))


def calibrated(
    counts: np.ndarray, values: Mapping[str, int], sensor: str, orientation: str
) -> np.ndarray:
    """(n, 3) raw counts as the device measured them: int16 without offsets and misalignment, in the
    board's axes.

    values : settings by full name.  sensor: gyro, acc, mag; orientation: imu, mag.
    """
    # What has no setting is zero: the accelerometer's upper part.
    names = [[f"{sensor}.{row}{column}_q16" for column in "xyz"] for row in "xyz"]
    matrix_q16 = [[values.get(name, 0) for name in row] for row in names]
    offset_q3 = [values[f"{sensor}.offset_q3_{axis}"] for axis in range(3)]
    turn = ImuTurn(values[f"{orientation}.orientation"])
    return turn.block(ImuCal(matrix_q16, offset_q3).block(counts))


def _fields(
    inertial: Inertial, run: Run, values: Mapping[str, int]
) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) the newest field at each sample of a run, and (n,) whether it is used there.

    It is used until the magnetometer is gone, which ATTITUDE tells by HEADING. Where a chain begins
    anew the field stays, as it was calibrated before.
    """
    mag, imu, count = inertial.mag, inertial.imu, run.end - run.begin
    is_past = mag["order"] < (imu["order"][run.until] if run.until < len(imu["order"]) else np.inf)
    mine = np.flatnonzero((mag["boot"] == run.boot) & is_past)
    if not len(mine):
        return np.zeros((count, 3), np.int16), np.zeros(count, bool)
    # A MAG comes behind the IMU of the sample with which it is first used.
    used_from = np.searchsorted(imu["order"][: run.until], mag["order"][mine]) - 1 - run.begin
    newest = np.searchsorted(used_from, np.arange(count), side="right") - 1
    fields = np.empty((len(mine), 3), np.int16)
    is_old = used_from < 0
    fields[~is_old] = calibrated(counts_of(mag)[mine[~is_old]], values, "mag", "mag")
    if is_old.any():
        last = mine[is_old][-1:]
        before = settings_at(inertial, int(mag["order"][last[0]]))
        fields[np.count_nonzero(is_old) - 1] = calibrated(
            counts_of(mag)[last], before, "mag", "mag"
        )
    has_heading = told_flags(inertial, run, AttitudeFlag.HEADING)
    # It goes where a heading is told no more, but none is told while the inclination is being set;
    # and comes with the next field.
    starts = told_flags(inertial, run, AttitudeFlag.RESTARTED)
    goes = ~has_heading & (_last(has_heading) > _last(starts))
    comes = has_heading | (np.diff(newest, prepend=newest[:1]) != 0)
    is_gone = _last(goes) > _last(comes)
    is_kept = (used_from[np.clip(newest, 0, None)] >= 0) | _had_field(inertial, run)
    return fields[np.clip(newest, 0, None)], (newest >= 0) & is_kept & ~is_gone


def _last(is_set: np.ndarray) -> np.ndarray:
    """(n,) at each place the last one up to there that is set; -1: none yet."""
    return np.maximum.accumulate(np.where(is_set, np.arange(len(is_set)), -1))


def _had_field(inertial: Inertial, run: Run) -> bool:
    """Whether a field was used before a run: the last ATTITUDE that could, told a heading, or one
    came behind it."""
    attitude, mag, begin = inertial.attitude, inertial.mag, inertial.imu["order"][run.begin]
    flags = attitude["flags"]
    tells = (flags & int(AttitudeFlag.RESTARTED) == 0) & (attitude["order"] < begin)
    at = np.flatnonzero(tells & (attitude["boot"] == run.boot))
    if not len(at) or flags[at[-1]] & int(AttitudeFlag.HEADING):
        return True
    return bool(((mag["order"] > attitude["order"][at[-1]]) & (mag["order"] < begin)).any())
