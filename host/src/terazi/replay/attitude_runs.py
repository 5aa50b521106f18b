# SPDX-License-Identifier: MIT
"""Where the attitude chain's state is known: from its start on, as long as no sample is missing.

The chain starts where the device does, and where a setting of it is changed; its samples count from
1 then. A sample that the device itself missed is no hole: it says so with GAP, and bridges it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from terazi.link.generated.messages import AttitudeFlag, Setting
from terazi.link.generated.settings import SETTINGS
from terazi.recorder.inertial import Inertial

SAMPLE_PERIOD = 1 << 16
FIRST_SAMPLE = 1
GAP_MAX_US = 50_000  # attitude.c: after more the inclination is set anew
LOST = SAMPLE_PERIOD - 1
GROUPS = ("imu", "acc", "gyro", "mag")  # of settings that the chain knows
# Changed without a new start of the chain, and without a trace in it.
NO_MATTER = ("imu.tilt_limit_mrad", "imu.lamp")
KEYS = {one.key: one.full_name for one in SETTINGS if one.group in GROUPS}


def are_told(values: Mapping[str, int]) -> bool:
    """Whether these, by full name, are all settings of the chain."""
    return set(values) == set(KEYS.values())


@dataclass(frozen=True)
class Run:
    """Raw samples [begin, end) from a start of the chain on, none missing.

    until : where the next run begins, or the samples end;  boot : of the device.
    lost : by the place of a sample, how many the device itself missed before it, or LOST.
    why : it ends before `until`; "": it does not.
    """

    begin: int
    end: int
    until: int
    boot: int
    lost: Mapping[int, int] = field(default_factory=dict)
    why: str = ""


def runs_of(inertial: Inertial) -> list[Run]:
    """One for each start of the chain; an empty one says why nothing of it is known."""
    imu = inertial.imu
    number, boot = imu["sample"].astype(np.int64), imu["boot"]
    if not len(number):
        return []
    other_boot = np.diff(boot, prepend=boot[:1] - 1) != 0
    anew = (number == FIRST_SAMPLE) & (np.roll(number, 1) != FIRST_SAMPLE - 1)
    begins = np.flatnonzero(other_boot | anew).tolist()
    return [
        _whole(inertial, Run(begin, until, until, int(boot[begin])))
        for begin, until in zip(begins, [*begins[1:], len(number)], strict=True)
    ]


def _whole(inertial: Inertial, run: Run) -> Run:
    """The run up to where a sample is missing."""
    imu = inertial.imu
    if int(imu["sample"][run.begin]) != FIRST_SAMPLE:
        why = "recorded from mid-stream, the filter's state is unknown"
        return replace(run, end=run.begin, why=why)
    place = slice(run.begin, run.end)
    missed = np.diff(unwrapped(imu["sample"][place])) - 1
    was_lost = np.diff(imu["lost"][place]) > 0
    is_told = told_flags(inertial, run, AttitudeFlag.GAP)[1:]
    has_fields = bool((inertial.mag["boot"] == run.boot).any())  # any frame may have been one
    broken = np.flatnonzero((missed > 0) & (was_lost | ~is_told) | has_fields & was_lost)
    if len(broken):
        why = "frames were lost on the way, and the filter's state with them"
        # A field comes behind the sample with which it is used first.
        known = int(broken[0]) + (not (has_fields and was_lost[broken[0]]))
        run = replace(run, end=run.begin + known, why=why)
    # An IMU that was away counts no samples meanwhile. It may say so for as long as it starts.
    says_anew = told_flags(inertial, run, AttitudeFlag.RESTARTED)
    away = says_anew[1:] & ~says_anew[:-1]
    away |= np.diff(imu["device_us"][run.begin : run.end]) > GAP_MAX_US
    lost = np.where(away, LOST, missed[: len(away)])
    at = np.flatnonzero(lost)
    return replace(run, lost={run.begin + 1 + int(one): int(lost[one]) for one in at})


def told_flags(inertial: Inertial, run: Run, flag: AttitudeFlag) -> np.ndarray:
    """(n,) bool, for each sample of a run: whether its ATTITUDE has a flag; where none came, as
    the one before (events: no)."""
    attitude, ready_us = inertial.attitude, inertial.imu["device_us"][run.begin : run.end]
    mine = np.flatnonzero(attitude["boot"] == run.boot)
    is_set = np.zeros(len(ready_us), bool)
    if not len(mine) or not len(ready_us):
        return is_set
    us = attitude["device_us"][mine]
    at = np.clip(np.searchsorted(us, ready_us, side="right") - 1, 0, None)
    is_there = us[at] <= ready_us if flag == AttitudeFlag.HEADING else us[at] == ready_us
    is_set[:] = is_there & (attitude["flags"][mine][at] & int(flag) != 0)
    return is_set


def unwrapped(numbers: np.ndarray) -> np.ndarray:
    """Numbers of samples without the step back at SAMPLE_PERIOD."""
    numbers = numbers.astype(np.int64)
    steps = np.diff(numbers) % SAMPLE_PERIOD
    return numbers[:1] + np.concatenate([np.zeros(min(len(numbers), 1), np.int64), steps]).cumsum()


# --- settings ---


def settings_at(inertial: Inertial, order: int) -> dict[str, int]:
    """Values by full name of what the chain was set to at a place among all that came.

    What was told before holds; what was told later only, held before, too.
    """
    values: dict[str, int] = {}
    for at, one in inertial.told:
        if isinstance(one.message, Setting) and one.message.key in KEYS:
            name = KEYS[one.message.key]
            if at < order or name not in values:
                values[name] = one.message.value
    return values


def until_changed(inertial: Inertial, run: Run, values: Mapping[str, int]) -> Run:
    """The run, up to where a setting is told to be another without a new start of the chain."""
    order = inertial.imu["order"]
    for at, one in inertial.told:
        if not isinstance(one.message, Setting) or one.message.key not in KEYS:
            continue
        name = KEYS[one.message.key]
        end = int(np.searchsorted(order, at))
        if (
            name not in NO_MATTER
            and run.begin < end < run.end
            and values[name] != one.message.value
        ):
            return replace(run, end=end, why=f"{name} was changed while it was recorded")
    return run
