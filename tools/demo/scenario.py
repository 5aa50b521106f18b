# SPDX-License-Identifier: MIT
"""What lies on the scale in the demo, and what disturbs it, as functions of seconds since reset.

Weights are placed and removed on a bench that a machine shakes, with a cell whose leads pick up the
mains. Amplitudes are chosen, not measured: such that the raw signal cannot be read to a gram and
each stage of the chain has something to do. Nothing here is random between runs.
"""

import numpy as np

# When a load comes to lie on the pan, and how heavy all of it then is.
LOADS_S_G = ((0.0, 0.0), (5.0, 500.0), (10.0, 1500.0), (15.0, 200.0), (20.0, 0.0))
SECONDS = 25.0

# A thing put down does not arrive at once: the pan swings on the cell's own stiffness.
PAN_HZ = 23.0
PAN_DECAY_S = 0.06
PAN_SHARE = 0.3  # of the step

# A belt and a fan on the same bench: frequency, amplitude, and how slowly the amplitude wanders.
VIBRATIONS_HZ_G_HZ = ((13.7, 6.0, 0.31), (17.3, 3.5, 0.23))
HUM_HZ, HUM_G = 50.0, 2.5

# HX711 at gain 128 and 80 SPS: 90 nV rms of a 20 mV half-scale, 38 counts; 2.328 mg a count.
NOISE_G = 0.09
NOISE_SLOT_S = 1e-3  # finer than any conversion, so that each draws its own value
NOISE_G_BY_SLOT = np.random.default_rng(seed=711).normal(0.0, NOISE_G, 65536)


def load_g(elapsed_s):
    """What the scale should say: the weights that lie on it. Scalar or array."""
    elapsed_s = np.asarray(elapsed_s, dtype=float)
    result_g, before_g = np.zeros_like(elapsed_s), 0.0
    for start_s, total_g in LOADS_S_G:
        result_g += (total_g - before_g) * (elapsed_s >= start_s)
        before_g = total_g
    return result_g


def disturbance_g(elapsed_s):
    """Pan, machine, mains and converter. Scalar or array."""
    elapsed_s = np.asarray(elapsed_s, dtype=float)
    result_g, before_g = np.zeros_like(elapsed_s), 0.0
    for start_s, total_g in LOADS_S_G:
        since_s = np.maximum(elapsed_s - start_s, 0.0)
        swing = np.exp(-since_s / PAN_DECAY_S) * np.cos(2 * np.pi * PAN_HZ * since_s)
        result_g -= PAN_SHARE * (total_g - before_g) * swing * (elapsed_s >= start_s)
        before_g = total_g
    for frequency_hz, amplitude_g, wander_hz in VIBRATIONS_HZ_G_HZ:
        wander = 0.75 + 0.25 * np.sin(2 * np.pi * wander_hz * elapsed_s)
        result_g += amplitude_g * wander * np.sin(2 * np.pi * frequency_hz * elapsed_s)
    result_g += HUM_G * np.sin(2 * np.pi * HUM_HZ * elapsed_s)
    slot = (elapsed_s / NOISE_SLOT_S).astype(np.int64) % len(NOISE_G_BY_SLOT)
    return result_g + NOISE_G_BY_SLOT[slot]


def grams(elapsed_s):
    """What the load cell feels. Scalar or array."""
    return load_g(elapsed_s) + disturbance_g(elapsed_s)


grams.truth_g = load_g  # what the bench writes down as the truth
