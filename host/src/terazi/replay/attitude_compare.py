# SPDX-License-Identifier: MIT
"""What the device's ATTITUDEs are against this host's C, and of which nothing can be said."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np

from terazi.link.generated.messages import AttitudeFlag
from terazi.recorder.inertial import Inertial
from terazi.recorder.recording import Recording
from terazi.replay.attitude import RATES_HZ, Replayed, replay_run
from terazi.replay.attitude_runs import Run, are_told, runs_of, settings_at, until_changed
from terazi.replay.stage import StageResult
from terazi.replay.unverified import Unverified

COMPONENTS = ("quat_w_q30", "quat_x_q30", "quat_y_q30", "quat_z_q30")
STAGES = {"rest": AttitudeFlag.REST | AttitudeFlag.BIAS_KNOWN, "still": AttitudeFlag.STILL}
NOT_RECORDED = "its raw sample was not recorded"
NONE_RECORDED = "no raw sample was recorded; `terazi log --imu` does"
NOT_TOLD = "no SETTING tells how the IMU was set; `terazi log` asks for them"


def compare_attitude(recording: Recording) -> tuple[list[StageResult], list[Unverified]]:
    """The quaternions, bit for bit, and what is said of stillness; nothing without ATTITUDE."""
    inertial = recording.inertial
    count = len(inertial.attitude["sample"])
    if not count:
        return [], []
    stages = [StageResult("attitude"), *(StageResult(name) for name in STAGES)]
    whys: Counter[str] = Counter()
    for run in runs_of(inertial):
        whys += _compare_run(stages, inertial, run)
    rest = count - stages[0].compared - whys.total()
    whys[NOT_RECORDED if len(inertial.imu["sample"]) else NONE_RECORDED] += rest
    return stages, [
        Unverified("attitude", samples, why) for why, samples in whys.items() if samples
    ]


def _compare_run(stages: list[StageResult], inertial: Inertial, run: Run) -> Counter[str]:
    """Compare the attitudes of a run; gives how many of its time were not, and why."""
    imu, attitude = inertial.imu, inertial.attitude
    values = settings_at(inertial, int(imu["order"][run.begin]))
    replayed = None
    why = _why_none(values) or ("" if run.end > run.begin else run.why)
    if not why:
        run = until_changed(inertial, run, values)
        try:
            replayed = replay_run(inertial, run, values)
        except ValueError as error:  # settings that no device takes
            why = str(error)
    mine = _attitudes_of(inertial, run)
    if replayed is None:
        return Counter({why: len(mine)})
    ready_us, us = imu["device_us"][run.begin : run.end], attitude["device_us"][mine]
    place = np.clip(np.searchsorted(ready_us, us), 0, len(ready_us) - 1)
    found = ready_us[place] == us
    _compare(stages, attitude, mine[found], replayed, place[found])
    behind = int(np.count_nonzero(us > ready_us[-1]))
    return Counter({run.why or NOT_RECORDED: behind})


def _why_none(values: Mapping[str, int]) -> str:
    """Why nothing of a run can be verified; "" where something can."""
    if not are_told(values):
        return NOT_TOLD
    if values["imu.mode"] not in RATES_HZ:
        return "imu.mode was none in which attitudes come"
    if values["imu.every"] != 1:
        return f"one in {values['imu.every']} samples was recorded, and imu.every=1 is needed"
    return ""


def _attitudes_of(inertial: Inertial, run: Run) -> np.ndarray:
    """Indices of the ATTITUDEs from a run's first sample on, up to the next run's."""
    imu, attitude = inertial.imu, inertial.attitude
    is_mine = (attitude["boot"] == run.boot) & (attitude["order"] > imu["order"][run.begin])
    if run.until < len(imu["order"]):
        is_mine &= attitude["order"] < imu["order"][run.until]
    return np.flatnonzero(is_mine)


def _compare(
    stages: list[StageResult],
    attitude: dict[str, np.ndarray],
    indices: np.ndarray,
    replayed: Replayed,
    place: np.ndarray,
) -> None:
    device = np.stack([attitude[name][indices] for name in COMPONENTS], axis=1)
    stages[0].add(attitude["sample"], indices, device, replayed.quats_q30[place])
    flags = attitude["flags"][indices]
    for stage, compared in zip(stages[1:], STAGES.values(), strict=True):
        mask = int(compared)
        stage.add(attitude["sample"], indices, flags & mask, replayed.flags[place] & mask)
