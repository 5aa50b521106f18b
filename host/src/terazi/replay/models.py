# SPDX-License-Identifier: MIT
"""The device's answers against the float64 models, from the raw counts on.

The chain of models is fed with raw counts alone, so that rounding adds up over the stages as it
does on the device; the budgets of terazi.models (derived in shared_c/notes) add up likewise. Only
segments with a known beginning are compared: the models have no state to take over.
"""

from dataclasses import dataclass

import numpy as np

from terazi import units
from terazi.models import fir as fir_model
from terazi.models import mass as mass_model
from terazi.models import weight_kf as weight_kf_model
from terazi.recorder.calibration import calibration_of
from terazi.recorder.recording import Recording
from terazi.replay.segments import Segment

MASS_BUDGET_MG = 0.5  # the C's one rounding, shared_c/notes/mass.md
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


def compare_with_models(
    recording: Recording, segments: list[Segment], design: str, schedule: str
) -> list[ModelResult]:
    """FIR, FIR and Kalman together, and mass."""
    fir = ModelResult("fir", "counts")
    chain = ModelResult("fir and kalman", "counts")
    samples = recording.samples
    for segment in segments:
        if not segment.is_primed:
            continue
        place = slice(segment.begin, segment.end)
        raw = samples["raw_counts"][place]
        smooth = fir_model.fir(raw, design=design)
        fir_budget = fir_model.error_budget_counts(
            design, peak_to_peak_counts=float(np.ptp(raw.astype(np.float64)))
        )
        fir.add(samples["fir_counts"][place], smooth, fir_budget)

        estimate = weight_kf_model.weight_kf(smooth, schedule=schedule)
        budget = weight_kf_model.error_budget_counts(
            smooth, schedule=schedule, input_error_counts=fir_budget
        )
        answered = units.counts_from_q7(samples["kf_counts_q7"][place].astype(np.float64))
        chain.add(answered, estimate, budget)
    return [fir, chain, _compare_mass(recording)]


def _compare_mass(recording: Recording) -> ModelResult:
    result = ModelResult("mass", "mg")
    held = calibration_of(recording)
    sure = held.is_certain
    net_counts = units.counts_from_q7(
        recording.samples["kf_counts_q7"].astype(np.float64) - held.tare_counts_q7
    )
    model_mg = mass_model.mass_mg(net_counts, held.span_ug_per_count_q16 / units.Q16_ONE)
    result.add(
        recording.samples["mass_mg"][sure].astype(np.float64),
        model_mg[sure],
        MASS_BUDGET_MG + MASS_FLOAT_MG,
    )
    return result
