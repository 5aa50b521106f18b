# SPDX-License-Identifier: MIT
"""Host throughput of the chip's filters beside scipy, and how far fixed point lies from float64.

scipy filters the same samples in float64 with the same transfer function in the same run, so that
the ratio says more than either figure on a machine that is busy with other things.
"""

import time
from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

from terazi import cshared
from terazi.models import fir as fir_model
from terazi.models import weight_kf as weight_kf_model

SAMPLES = 1 << 19
ACCURACY_SAMPLES = 1 << 14  # the float64 Kalman model is a Python loop
ROUNDS = 5
Q7 = 1 << 7
SEED = 20


def best_rate_per_s(count: int, *calls: Callable[[], object]) -> list[float]:
    """Items a second of each call: the best of some rounds, taken in turn."""
    best_s = [float("inf")] * len(calls)
    for _ in range(ROUNDS):
        for place, call in enumerate(calls):
            start_s = time.perf_counter()
            call()
            best_s[place] = min(best_s[place], time.perf_counter() - start_s)
    return [count / each_s for each_s in best_s]


def compared(count: int, ours: Callable, peer_name: str, peer: Callable) -> dict[str, object]:
    ours_per_s, peer_per_s = best_rate_per_s(count, ours, peer)
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


def measure() -> tuple[dict, dict]:
    """The `host` and `accuracy` parts of `./dev bench --json`."""
    counts = weighing_counts()
    as_float = counts.astype(np.float64)
    taps = fir_model.taps_q15("lowpass32") / 32768.0
    gain = weight_kf_model.gains("default")[-1]
    host = {
        "fir_block": compared(
            SAMPLES,
            lambda: cshared.fir_block(counts),
            "scipy.signal.lfilter",
            lambda: lfilter(taps, 1.0, as_float),
        ),
        "weight_kf_block": compared(
            SAMPLES,
            lambda: cshared.weight_kf_block(counts),
            "scipy.signal.lfilter",
            lambda: lfilter([gain], [1.0, gain - 1.0], as_float),
        ),
    }
    part = counts[:ACCURACY_SAMPLES]
    fir_error = cshared.fir_block(part) - fir_model.fir(part)
    kf_error = cshared.weight_kf_block(part) / Q7 - weight_kf_model.weight_kf(part)
    accuracy = {
        "fir_counts_max": round(float(np.abs(fir_error).max()), 4),
        "weight_kf_counts_max": round(float(np.abs(kf_error).max()), 4),
    }
    return host, accuracy
