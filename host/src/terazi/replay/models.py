# SPDX-License-Identifier: MIT
"""The device's answers against the float64 models, from the raw counts on.

The chain of models is fed with raw counts alone, so that rounding adds up over the stages as it
does on the device; the budgets of terazi.models (derived in shared_c/notes) add up likewise. Only
segments with a known beginning are compared: the models have no state to take over. The adaptive
filter has no budget that runs along the data: its model is fed with what the device fed to it, and
has one count.
"""

from dataclasses import dataclass

import numpy as np

from terazi import units
from terazi.link.generated.messages import ChainOrder, KfKind
from terazi.models import fir as fir_model
from terazi.models import scale as scale_model
from terazi.models import weight_kf as weight_kf_model
from terazi.models import weight_kf_adaptive as adaptive_model
from terazi.recorder.calibration import calibration_of
from terazi.recorder.chain import Chain, last_counts_q7
from terazi.recorder.recording import Recording
from terazi.replay.segments import Segment

ADAPTIVE_BUDGET_COUNTS = 1.0  # shared_c/notes/weight_kf_adaptive.md
HALF_COUNT = 0.5  # the estimate in whole counts, before a FIR
# What float64 itself may lose of a mass below 2^31 mg.
MASS_FLOAT_MG = 1e-6


@dataclass
class ModelResult:
    """How far one stage of the device lies from the mathematics."""

    stage: str
    unit: str
    compared: int = 0
    beyond: int = 0  # samples outside the budget
    largest: float = 0.0  # difference
    budget: float = 0.0  # its bound, where the difference comes nearest to it
    _nearest: float = 0.0

    def add(self, device: np.ndarray, model: np.ndarray, budget: np.ndarray | float) -> None:
        difference = np.abs(device - model)
        budget = np.broadcast_to(budget, difference.shape)
        share = difference / budget
        self.compared += len(difference)
        self.beyond += int(np.count_nonzero(share > 1.0))
        self.largest = max(self.largest, float(difference.max(initial=0.0)))
        if len(share) and share.max() >= self._nearest:
            self._nearest = float(share.max())
            self.budget = float(budget[int(np.argmax(share))])


STAGES = {
    (ChainOrder.FIR_KF, KfKind.CONSTANT): ("fir", "fir and kalman"),
    (ChainOrder.KF_FIR, KfKind.CONSTANT): ("kalman", "kalman and fir"),
    (ChainOrder.FIR_KF, KfKind.ADAPTIVE): ("fir", "adaptive"),
    (ChainOrder.KF_FIR, KfKind.ADAPTIVE): ("adaptive", "fir"),
}


class _Judge:
    """The models beside one recording."""

    def __init__(self, recording: Recording, design: str, schedule: str) -> None:
        self.samples = recording.samples
        self.design, self.schedule = design, schedule
        self.results: dict[str, ModelResult] = {}

    def add(self, stage: str, column: str, place: slice, model, budget) -> None:
        device = self.samples[column][place].astype(np.float64)
        if column == "kf_counts_q7":
            device = units.counts_from_q7(device)
        self.results[stage].add(device, model, budget)

    def fir(self, fed: np.ndarray, fed_budget: np.ndarray | float):
        """Model and budget of a FIR whose input may lie off by fed_budget."""
        largest = float(np.max(fed_budget))
        gain = np.abs(fir_model.taps_q15(self.design)).sum() / 32768.0
        span = float(np.ptp(fed.astype(np.float64))) + 2 * largest
        own = fir_model.error_budget_counts(self.design, peak_to_peak_counts=span)
        return fir_model.fir(fed, design=self.design), own + gain * largest

    def kalman(self, fed: np.ndarray, fed_budget: float):
        """Model and budget of the Kalman filter with constant gains."""
        model = weight_kf_model.weight_kf(fed, schedule=self.schedule)
        budget = weight_kf_model.error_budget_counts(
            fed, schedule=self.schedule, input_error_counts=fed_budget
        )
        return model, budget

    def judge(self, place: slice, order: int, kind: int) -> None:
        raw = self.samples["raw_counts"][place]
        adaptive = kind == KfKind.ADAPTIVE
        if order == ChainOrder.FIR_KF:
            smooth, budget = self.fir(raw, 0.0)
            self.add("fir", "fir_counts", place, smooth, budget)
            if adaptive:
                self.adaptive(place, self.samples["fir_counts"][place])
            else:
                self.add("fir and kalman", "kf_counts_q7", place, *self.kalman(smooth, budget))
            return
        if adaptive:
            self.adaptive(place, raw)
            estimate = self.samples["kf_counts_q7"][place]
            self.add("fir", "fir_counts", place, *self.fir((estimate + 64) >> 7, 0.0))
            return
        estimate, budget = self.kalman(raw, 0.0)
        self.add("kalman", "kf_counts_q7", place, estimate, budget)
        result = self.fir(estimate, budget + HALF_COUNT)
        self.add("kalman and fir", "fir_counts", place, *result)

    def adaptive(self, place: slice, fed: np.ndarray) -> None:
        model = adaptive_model.weight_kf_adaptive(fed)
        self.add("adaptive", "kf_counts_q7", place, model, ADAPTIVE_BUDGET_COUNTS)


def compare_with_models(
    recording: Recording, segments: list[Segment], design: str, schedule: str, chain: Chain
) -> list[ModelResult]:
    """Each filter, or the chain up to it, and mass."""
    judge = _Judge(recording, design, schedule)
    for segment in segments:
        known = chain.at(segment.begin)
        if known is None:
            continue
        for stage in STAGES[known]:
            judge.results.setdefault(stage, ModelResult(stage, "counts"))
        if segment.is_primed:
            judge.judge(slice(segment.begin, segment.end), *known)
    return [*judge.results.values(), _compare_mass(recording, chain)]


def _compare_mass(recording: Recording, chain: Chain) -> ModelResult:
    result = ModelResult("mass", "mg")
    counts = units.counts_from_q7(last_counts_q7(recording, chain).astype(np.float64))
    for stretch in calibration_of(recording):
        if stretch.points is None:
            continue
        known = np.arange(stretch.begin, stretch.end)
        known = known[chain.is_certain[known]]
        points = [(units.counts_from_q7(at_q7), mass_mg) for at_q7, mass_mg in stretch.points]
        result.add(
            recording.samples["mass_mg"][known].astype(np.float64),
            scale_model.mass_mg(counts[known], points),
            scale_model.MASS_BUDGET_MG + MASS_FLOAT_MG,
        )
    return result
