# SPDX-License-Identifier: MIT
"""Each stage by itself: fed with what the device fed to it, compared with what it answered.

    fir     raw_counts   -> fir_counts       the other order:  kf_counts_q7 in whole counts
    kalman  fir_counts   -> kf_counts_q7                       raw_counts
    mass    kf_counts_q7 -> mass_mg                            fir_counts
            by the calibration that held at the time

and where an IMU was recorded its chain: attitude.py, attitude_runs.py, attitude_compare.py.

Order and Kalman filter are those that the device announced, segment by segment.
Where a segment's beginning is unknown, the FIR is compared from the first sample whose whole
window was recorded, and the Kalman filter starts from the device's own answer once its gain
schedule must have ended; the adaptive one cannot be known then. Nothing is compared that is not
certain. The models' side: models.py
"""

import struct
from dataclasses import dataclass

import numpy as np

from terazi.cshared import (
    FIR_DESIGNS,
    WEIGHT_KF_SCHEDULES,
    Fir,
    Scale,
    WeightKf,
    WeightKfAdaptive,
)
from terazi.design import scale as scale_design
from terazi.errors import CannotRead
from terazi.link.generated.messages import ChainOrder, KfKind
from terazi.recorder.calibration import calibration_of
from terazi.recorder.chain import Chain, chain_of, last_counts_q7
from terazi.recorder.recording import Recording
from terazi.replay.attitude_compare import compare_attitude
from terazi.replay.models import ModelResult, compare_with_models
from terazi.replay.segments import Segment, segments_of
from terazi.replay.stage import StageResult
from terazi.replay.unverified import Unverified, unverified

SCHEDULE_MAX = 255  # gains, weight_kf.h


@dataclass
class Replay:
    """The verdict on one recording."""

    samples: int
    segments: list[Segment]
    design: str
    schedule: str
    chains: list[str]  # order and Kalman filter, each that was used, in turn
    stages: list[StageResult]
    models: list[ModelResult]
    unverified: list[Unverified]  # what nothing was said of, and why

    @property
    def agrees(self) -> bool:
        return self.is_bit_identical and all(model.beyond == 0 for model in self.models)

    @property
    def is_bit_identical(self) -> bool:
        return all(stage.differing == 0 for stage in self.stages)

    @property
    def unprimed(self) -> int:
        return sum(not segment.is_primed for segment in self.segments)


def replay(recording: Recording) -> Replay:
    """Replay a recording. Raises CannotRead for filters that this host does not know."""
    hello = recording.hello
    design = _known(FIR_DESIGNS, hello.fir_design, "FIR design")
    schedule = _known(WEIGHT_KF_SCHEDULES, hello.kf_schedule, "gain schedule")
    samples = recording.samples
    segments = segments_of(samples)
    chain = chain_of(recording)
    fir, kalman = StageResult("fir"), StageResult("kalman")
    for segment in segments:
        if (known := chain.at(segment.begin)) is None:
            continue
        order, kind = known
        _compare_fir(fir, samples, segment, design, order)
        if kind == KfKind.ADAPTIVE:
            _compare_adaptive(kalman, samples, segment, order)
        else:
            _compare_kalman(kalman, samples, segment, schedule, order)
    stretches = calibration_of(recording)
    attitude, of_attitude = compare_attitude(recording)
    return Replay(
        samples=len(recording),
        segments=segments,
        design=design,
        schedule=schedule,
        chains=_chains(chain, segments),
        stages=[fir, kalman, _compare_mass(recording, chain), *attitude],
        models=compare_with_models(recording, segments, design, schedule, chain),
        unverified=[
            *unverified(len(recording), segments, chain, stretches, design, kalman.compared),
            *of_attitude,
        ],
    )


def _known(names: tuple[str, ...], index: int, what: str) -> str:
    if index >= len(names):
        raise CannotRead(f"the recording was made with {what} {index}; this host has {len(names)}")
    return names[index]


def _chains(chain: Chain, segments: list[Segment]) -> list[str]:
    """What was announced, each change of it once."""
    found: list[str] = []
    for segment in segments:
        known = chain.at(segment.begin)
        name = "unknown"
        if known is not None:
            order, kind = ChainOrder(known[0]), KfKind(known[1])
            name = f"{order.name.lower()}, {kind.name.lower()}"
        if found[-1:] != [name]:
            found.append(name)
    return found


def fir_input(samples: dict, place: slice, order: int) -> np.ndarray:
    """What the device fed to its FIR: in the other order the estimate, half up."""
    if order == ChainOrder.FIR_KF:
        return samples["raw_counts"][place]
    return ((samples["kf_counts_q7"][place].astype(np.int64) + 64) >> 7).astype(np.int32)


def kf_input(samples: dict, place: slice, order: int) -> np.ndarray:
    """What the device fed to its Kalman filter."""
    return samples["fir_counts" if order == ChainOrder.FIR_KF else "raw_counts"][place]


def _place(segment: Segment) -> slice:
    return slice(segment.begin, segment.end)


def _compare_fir(result, samples: dict, segment: Segment, design: str, order: int) -> None:
    fed = fir_input(samples, _place(segment), order)
    fir = Fir(design, int(fed[0]))
    host = fir.block(fed)
    skip = 0 if segment.is_primed else fir.taps - 1
    _add(result, samples, "fir_counts", segment, host, skip)


def _compare_adaptive(result, samples: dict, segment: Segment, order: int) -> None:
    if segment.is_primed:
        fed = kf_input(samples, _place(segment), order)
        host = WeightKfAdaptive("default", int(fed[0])).block(fed)
        _add(result, samples, "kf_counts_q7", segment, host, 0)


def _compare_kalman(result, samples: dict, segment: Segment, schedule: str, order: int) -> None:
    measured = kf_input(samples, _place(segment), order)
    if segment.is_primed:
        host = WeightKf(schedule, int(measured[0])).block(measured)
        _add(result, samples, "kf_counts_q7", segment, host, 0)
        return
    steady = _Steady(schedule)
    skip = steady.gains_used
    if len(segment) <= skip + 1:
        return
    kf = steady.started_at(int(samples["kf_counts_q7"][segment.begin + skip]))
    host = np.concatenate([np.zeros(skip + 1, np.int32), kf.block(measured[skip + 1 :])])
    _add(result, samples, "kf_counts_q7", segment, host, skip + 1)


def _add(result, samples: dict, name: str, segment: Segment, host: np.ndarray, skip: int) -> None:
    indices = np.arange(segment.begin + skip, segment.end)
    result.add(samples["conversion"], indices, samples[name][indices], host[skip:])


class _Steady:
    """A Kalman filter whose gain schedule has ended, to be started at any estimate."""

    def __init__(self, schedule: str) -> None:
        self._kf = WeightKf(schedule, 0)
        self._kf.block(np.zeros(SCHEDULE_MAX, np.int32))
        _estimate, self.gains_used, _clipped = struct.unpack("<iBH", self._kf.save())

    def started_at(self, estimate_counts_q7: int) -> WeightKf:
        self._kf.restore(struct.pack("<iBH", estimate_counts_q7, self.gains_used, 0))
        return self._kf


def _compare_mass(recording: Recording, chain: Chain) -> StageResult:
    result = StageResult("mass")
    samples = recording.samples
    last_q7 = last_counts_q7(recording, chain)
    for stretch in calibration_of(recording):
        if stretch.points is None:
            continue
        known = np.arange(stretch.begin, stretch.end)
        known = known[chain.is_certain[known]]
        host = scale_of(stretch.points).masses(last_q7[known])
        result.add(samples["conversion"], known, samples["mass_mg"][known], host)
    return result


def scale_of(points: tuple[tuple[int, int], ...]) -> Scale:
    """A scale with a calibration's points, (counts_q7, mass_mg), as the device holds them."""
    columns = zip(*points, strict=True)
    room = scale_design.POINTS_MAX - len(points)
    counts_q7, mass_mg = ([*column, *[0] * room] for column in columns)
    calibration = {"point_counts_q7": counts_q7, "point_mass_mg": mass_mg, "points": len(points)}
    return Scale(scale_design.config() | calibration)
