# SPDX-License-Identifier: MIT
"""Host throughput of the chip's filters beside others, and how far fixed point lies from float64.

scipy filters the same samples in float64 with the same transfer function, filterpy with the same
equations a sample a call, all in the same run: the ratio says more than either figure on a machine
that is busy with other things.
"""

import time
from collections.abc import Callable

import numpy as np
from filterpy.kalman import KalmanFilter
from scipy.signal import lfilter

from terazi import cshared
from terazi.models import fir as fir_model
from terazi.models import weight_kf as weight_kf_model

SAMPLES = 1 << 19
ACCURACY_SAMPLES = 1 << 14  # the float64 Kalman model is a Python loop
PER_SAMPLE_SAMPLES = 1 << 12  # for peers that take one sample a call
ROUNDS = 5
Q7 = 1 << 7
SEED = 20


def best_seconds(*calls: Callable[[], object]) -> list[float]:
    """Of each call the best of some rounds, taken in turn."""
    best_s = [float("inf")] * len(calls)
    for _ in range(ROUNDS):
        for place, call in enumerate(calls):
            start_s = time.perf_counter()
            call()
            best_s[place] = min(best_s[place], time.perf_counter() - start_s)
    return best_s


def compared(
    count: int, ours: Callable, peer_name: str, peer: Callable, *, peer_count: int | None = None
) -> dict[str, object]:
    """Samples a second of both; peer_count: how many the peer takes, where it is much slower."""
    ours_s, peer_s = best_seconds(ours, peer)
    ours_per_s, peer_per_s = count / ours_s, (peer_count or count) / peer_s
    return {
        "ours_per_s": round(ours_per_s),
        "peer": peer_name,
        "peer_per_s": round(peer_per_s),
        "ratio": round(ours_per_s / peer_per_s, 3),
    }


def weighing_counts() -> np.ndarray:
    """Loads that come and go, in converter noise and vibration."""
    rng = np.random.default_rng(SEED)
    steps = np.repeat(rng.integers(-1_000_000, 1_000_000, SAMPLES // 512), 512)
    shake = 3000 * np.sin(2 * np.pi * 13.7 / 80 * np.arange(SAMPLES))
    return np.rint(steps + shake + rng.normal(0, 39, SAMPLES)).astype(np.int32)


def filterpy_estimates(counts: np.ndarray) -> np.ndarray:
    """The same scalar filter by filterpy, as people use it: predict and update a sample a call."""
    schedule = weight_kf_model.specs.weight_kf_schedule("default")
    kf = KalmanFilter(dim_x=1, dim_z=1)
    kf.F, kf.H = np.eye(1), np.eye(1)
    kf.x = np.array([[float(counts[0])]])
    kf.P, kf.Q, kf.R = (
        np.array([[float(schedule[name])]]) for name in ("initial_var", "process_var", "noise_var")
    )
    estimates = np.empty(counts.size)
    for n, measured in enumerate(counts.tolist()):
        kf.predict()
        kf.update(measured)
        estimates[n] = kf.x[0, 0]
    return estimates


def throughput() -> dict[str, dict]:
    """The rows of the chip's filters in the `host` part of `./dev bench --json`."""
    counts = weighing_counts()
    as_float = counts.astype(np.float64)
    gain = weight_kf_model.gains("default")[-1]
    few = counts[:PER_SAMPLE_SAMPLES]

    def fir_beside_lfilter(design: str) -> dict[str, object]:
        taps = fir_model.taps_q15(design) / 32768.0
        return compared(
            SAMPLES,
            lambda: cshared.fir_block(counts, design),
            "scipy.signal.lfilter",
            lambda: lfilter(taps, 1.0, as_float),
        )

    return {
        "fir_block": fir_beside_lfilter("lowpass32"),
        "fir_block_15": fir_beside_lfilter("hamming15"),
        "fir_block_51": fir_beside_lfilter("passband51"),
        "fir_block_64": fir_beside_lfilter("lowpass64"),
        "weight_kf_block": compared(
            SAMPLES,
            lambda: cshared.weight_kf_block(counts),
            "filterpy.kalman.KalmanFilter, a sample a call",
            lambda: filterpy_estimates(few),
            peer_count=few.size,
        ),
        "weight_kf_block_beside_lfilter": compared(
            SAMPLES,
            lambda: cshared.weight_kf_block(counts),
            "scipy.signal.lfilter",
            lambda: lfilter([gain], [1.0, gain - 1.0], as_float),
        ),
    }


def accuracy() -> dict[str, float]:
    """Largest differences in counts, all loads and jumps included."""
    part = weighing_counts()[:ACCURACY_SAMPLES]
    few = part[:PER_SAMPLE_SAMPLES]
    differences = {
        "fir_counts_max": cshared.fir_block(part) - fir_model.fir(part),
        "weight_kf_counts_max": cshared.weight_kf_block(part) / Q7
        - weight_kf_model.weight_kf(part),
        "weight_kf_counts_max_from_filterpy": cshared.weight_kf_block(few) / Q7
        - filterpy_estimates(few),
    }
    return {name: round(float(np.abs(each).max()), 4) for name, each in differences.items()}
