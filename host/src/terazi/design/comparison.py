# SPDX-License-Identifier: MIT
"""Eggs on a moving belt: an adaptive line enhancer against windows, after Yanik 2017.

Their records are not published, so this is an experiment of ours after theirs: LMS against the
Hamming, Blackman, von Hann and rectangular windows. Everything in it is stated here and seeded.

What it shows: the enhancer, which must take a mean off before it can learn, remembers twice as many
samples as a window of that mean's length. Beside windows of that length it wins where the belt is
so slow that they let it pass. Beside one window of twice the length, which costs the same time to
settle, it wins little or nothing; and where an egg stays for less than that, neither is settled.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from terazi.design import specs, windows
from terazi.models import lms

WINDOWS = ("hamming", "blackman", "hann", "rectangular")
BELTS_HZ = (2.2, 4.3, 9.0)  # inside the windows' main lobe, at its edge, and well outside
LONG = "hann, twice as long"
EGG_G = (45.0, 75.0)  # S to XL
COUNTS_PER_G = 429.55  # the default span's inverse, shared_c/include/mass.h


@dataclass(frozen=True)
class Experiment:
    """What is simulated. Frequencies are of the belt; the rhythm wanders and has one harmonic."""

    seed: int = 2017
    rate_hz: float = 80.0
    eggs: int = 120
    dwell_s: float = 1.0  # an egg on the scale, the next follows at once
    read_before_end_s: float = 0.0125  # the sample before the egg leaves
    noise_g: float = 0.09  # of the converter, standard deviation
    belt_hz: float = 4.3
    belt_g: float = 2.0  # amplitude of the rhythm
    harmonic_g: float = 0.8
    wander_hz: float = 0.02  # of the belt, random walk a second
    taps: int = 32
    lms_taps: int = 32
    lms_step: float = 0.02


@dataclass(frozen=True)
class Row:
    """How a filter read the eggs."""

    filter: str
    relative_error_pct: float  # mean of |read - true| / true
    worst_error_pct: float
    bias_g: float
    spread_g: float  # standard deviation of read - true


def run(experiment: Experiment) -> list[Row]:
    """A row for each filter, the unfiltered reading first."""
    samples_g, true_g, reads = signal(experiment)
    settled = slice(len(true_g) // 6, None)  # the first sixth is for learning, for all alike
    taps = experiment.taps
    kernels = {name: windows.lowpass(name, taps, 0.0, experiment.rate_hz) for name in WINDOWS}
    kernels["lowpass32"] = specs.fir_taps("lowpass32")
    kernels[LONG] = windows.lowpass("hann", 2 * taps - 1, 0.0, experiment.rate_hz)
    outputs = {"none": samples_g}
    outputs |= {name: causal(samples_g, kernel) for name, kernel in kernels.items()}
    cleaned = lms.line_enhancer(
        samples_g * COUNTS_PER_G,
        taps=experiment.lms_taps,
        step=experiment.lms_step,
        mean_samples=taps,
    )
    rest_g = cleaned.rest_counts / COUNTS_PER_G
    outputs["lms"] = rest_g
    outputs["lms, rectangular"] = causal(rest_g, kernels["rectangular"])
    return [_row(name, out[reads][settled], true_g[settled]) for name, out in outputs.items()]


def signal(experiment: Experiment):
    """Samples in gram (n,), each egg's true mass, and the index at which each is read."""
    rng = np.random.default_rng(experiment.seed)
    rate_hz = experiment.rate_hz
    each = round(experiment.dwell_s * rate_hz)
    true_g = rng.uniform(*EGG_G, experiment.eggs)
    load_g = np.repeat(true_g, each)
    wander = np.cumsum(rng.normal(0, experiment.wander_hz / np.sqrt(rate_hz), load_g.size))
    turns = np.cumsum(experiment.belt_hz + wander) / rate_hz
    rhythm_g = experiment.belt_g * np.sin(2 * np.pi * turns)
    rhythm_g += experiment.harmonic_g * np.sin(4 * np.pi * turns + 1.0)
    noise_g = rng.normal(0, experiment.noise_g, load_g.size)
    back = max(1, round(experiment.read_before_end_s * rate_hz))
    reads = np.arange(1, experiment.eggs + 1) * each - back
    return load_g + rhythm_g + noise_g, true_g, reads


def causal(samples, kernel):
    """FIR over samples, primed with the first of them."""
    primed = np.concatenate([np.full(kernel.size - 1, samples[0]), samples])
    return np.convolve(primed, kernel, mode="valid")


def _row(name: str, read_g, true_g) -> Row:
    error_g = read_g - true_g
    relative = np.abs(error_g) / true_g * 100
    return Row(
        name,
        float(relative.mean()),
        float(relative.max()),
        float(error_g.mean()),
        float(error_g.std()),
    )


def as_json(experiment: Experiment, rows: list[Row]) -> dict:
    """One object: what was simulated, and a row by the filter's name."""
    return {"experiment": asdict(experiment), "filters": {row.filter: asdict(row) for row in rows}}
