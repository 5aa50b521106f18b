# SPDX-License-Identifier: MIT
"""When does the foot stand still? Each detector gives a motion and a threshold, in one unit.

    moving_variance   variance of the acceleration in a short window        (m/s^2)^2 -> its root
    magnitude         the acceleration's size against gravity               m/s^2
    rate_energy       angular rate, root of the mean square                 rad/s
    shoe              acceleration less gravity along its own mean, and angular rate, in one
                      mean square (Skog, Haendel, Nilsson, Rantakokko 2010)  rad/s
    adaptive_shoe     the same against a threshold that follows its own minimum near by
    learnt            a small recurrent network's doubt, 1 - probability    of 1 (networks.py); its
                      threshold follows its least value near by as well
    device            what the device said that recorded the walk
    low_pass          the acceleration's size, high-passed, rectified and low-passed (Butterworth)
                      g, as x-io's gait example and the article have it

SHOE's two terms are published as chi-squares of sigmas that no sensor has; only the ratio of the
sigmas counts. Here the sum is divided by the rate's, so that a threshold is a rate: "a foot that
turns with less than 0.3 rad/s". `m_s2_per_rad_s` says how much acceleration weighs as much.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from terazi.applications.walks.butterworth import Butterworth
from terazi.applications.walks.networks import Network
from terazi.applications.walks.record import Walk
from terazi.applications.walks.windows import moving_mean, moving_min, moving_variance, odd_length
from terazi.errors import CannotRead

GRAVITY_M_S2 = 9.81


@dataclass(frozen=True)
class Detection:
    """motion and threshold (n,), in the detector's unit; the foot stands where motion is less."""

    motion: np.ndarray
    threshold: np.ndarray
    unit: str
    ahead_s: float = 0.0  # how much of the future a decision knows
    detector: str = ""  # which it is, for people
    at_once: Detection | None = None  # what was decided from the past alone; None: the same

    @property
    def still(self) -> np.ndarray:
        """(n,) bool."""
        return self.motion < self.threshold

    @property
    def doubt(self) -> np.ndarray:
        """(n,) square of motion by threshold: 0 surely still, 1 at the threshold."""
        return (self.motion / self.threshold) ** 2


@dataclass(frozen=True)
class Fixed:
    """A window and a threshold that never changes."""

    window_s: float
    threshold: float


@dataclass(frozen=True)
class AdaptiveShoe:
    """threshold = low <= more x least motion near by <= high."""

    window_s: float
    m_s2_per_rad_s: float
    near_s: float
    more: float
    low_rad_s: float
    high_rad_s: float


MOVING_VARIANCE = Fixed(0.045, 0.35)
MAGNITUDE = Fixed(0.045, 1.2)
RATE_ENERGY = Fixed(0.045, 1.0)
SHOE = Fixed(0.045, 0.9)
LOW_PASS = Fixed(0.0, 0.1)
SHOE_M_S2_PER_RAD_S = 11.0
LOW_PASS_HZ = 5.0
LEARNT_NEAR_S, LEARNT_HIGH = 1.2, 0.8
LEARNT_MORE, LEARNT_MORE_AT_ONCE = 1.4, 2.2
HIGH_PASS_HZ = 0.001

STANDS, MOVES = 0.5, 2.0  # a motion of yes and no, beside a threshold of 1

ADAPTIVE_BATCH = AdaptiveShoe(0.025, 4.4, 1.29, 1.45, 0.118, 1.94)
ADAPTIVE_CAUSAL = AdaptiveShoe(0.025, 4.4, 1.25, 2.2, 0.118, 1.94)
"""Generous: zero velocity that comes too early weighs little and is soon revised, a stance that is
missed costs a swing."""


def _fixed(walk: Walk, motion, settings: Fixed, unit: str, *, causal: bool) -> Detection:
    threshold = np.full(len(walk), float(settings.threshold))
    return Detection(motion, threshold, unit, 0.0 if causal else settings.window_s / 2)


def moving_variance_detector(walk: Walk, settings: Fixed, *, causal: bool) -> Detection:
    """Root of the acceleration's variance."""
    length = odd_length(settings.window_s, walk.rate_hz)
    motion = np.sqrt(moving_variance(walk.acc_b_m_s2, length, causal=causal))
    return _fixed(walk, motion, settings, "m/s²", causal=causal)


def magnitude_detector(walk: Walk, settings: Fixed, *, causal: bool) -> Detection:
    """How far the acceleration's size is from gravity, root of the mean square."""
    length = odd_length(settings.window_s, walk.rate_hz)
    away = np.linalg.norm(walk.acc_b_m_s2, axis=1) - GRAVITY_M_S2
    motion = np.sqrt(moving_mean(away**2, length, causal=causal))
    return _fixed(walk, motion, settings, "m/s²", causal=causal)


def rate_energy_detector(walk: Walk, settings: Fixed, *, causal: bool) -> Detection:
    """Angular rate, root of the mean square."""
    length = odd_length(settings.window_s, walk.rate_hz)
    motion = np.sqrt(moving_mean(np.sum(walk.gyro_b_rad_s**2, axis=1), length, causal=causal))
    return _fixed(walk, motion, settings, "rad/s", causal=causal)


def shoe_motion(walk: Walk, window_s: float, m_s2_per_rad_s: float, *, causal: bool) -> np.ndarray:
    """(n,) rad/s."""
    length = odd_length(window_s, walk.rate_hz)
    acc = walk.acc_b_m_s2
    mean = moving_mean(acc, length, causal=causal)
    along = mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-9)
    # mean |a - g u|^2 = mean |a|^2 - 2 g u . mean a + g^2, for u does not change in the window.
    force = moving_mean(np.sum(acc**2, axis=1), length, causal=causal)
    force = force - 2 * GRAVITY_M_S2 * np.sum(along * mean, axis=1) + GRAVITY_M_S2**2
    turning = moving_mean(np.sum(walk.gyro_b_rad_s**2, axis=1), length, causal=causal)
    return np.sqrt(np.maximum(turning + force / m_s2_per_rad_s**2, 0.0))


def shoe_detector(walk: Walk, settings: Fixed, *, causal: bool) -> Detection:
    """SHOE with one threshold for all."""
    motion = shoe_motion(walk, settings.window_s, SHOE_M_S2_PER_RAD_S, causal=causal)
    return _fixed(walk, motion, settings, "rad/s", causal=causal)


def adaptive_shoe_detector(walk: Walk, settings: AdaptiveShoe, *, causal: bool) -> Detection:
    """SHOE against its own least value near by: within near_s around, or in the past near_s."""
    motion = shoe_motion(walk, settings.window_s, settings.m_s2_per_rad_s, causal=causal)
    length = odd_length(settings.near_s, walk.rate_hz)
    least = moving_min(motion, length, causal=causal)
    threshold = np.clip(settings.more * least, settings.low_rad_s, settings.high_rad_s)
    ahead_s = 0.0 if causal else (settings.near_s + settings.window_s) / 2
    return Detection(motion, threshold, "rad/s", ahead_s)


def learnt_detectors(
    walk: Walk, network: Network, *, least_doubt: float | None = None
) -> tuple[Detection, Detection]:
    """A network's doubt, 1 - probability, against its own least value near by, as for SHOE: what is
    accepted at one fixed probability misses every stance of some walkers. In the end; at once.

    least_doubt : lowest threshold; None: what the network's file accepts.
    """
    motion = 1 - network.probability(walk)
    low = 1 - network.accept if least_doubt is None else least_doubt
    length = odd_length(LEARNT_NEAR_S, walk.rate_hz)

    def detection(causal: bool, more: float) -> Detection:
        least = moving_min(motion, length, causal=causal)
        threshold = np.clip(more * least, low, max(low, LEARNT_HIGH))
        return Detection(motion, threshold, "doubt", 0.0 if causal else LEARNT_NEAR_S / 2)

    return detection(False, LEARNT_MORE), detection(True, LEARNT_MORE_AT_ONCE)


def low_pass_detector(walk: Walk, settings: Fixed, *, causal: bool) -> Detection:
    """The acceleration's size without its constant part, rectified and smoothed, in g."""
    size = np.linalg.norm(walk.acc_b_m_s2, axis=1) / GRAVITY_M_S2
    high = Butterworth(HIGH_PASS_HZ, walk.rate_hz, high=True)
    low = Butterworth(LOW_PASS_HZ, walk.rate_hz)
    run = (lambda f, x: f.forward(x)) if causal else (lambda f, x: f.both_ways(x))
    motion = np.abs(run(low, np.abs(run(high, size))))
    threshold = np.full(len(walk), float(settings.threshold))
    return Detection(motion, threshold, "g", 0.0 if causal else np.inf)


def device_detector(walk: Walk, *, causal: bool) -> Detection:
    """Zero velocity as the device told it; of a recorded walk its delay is taken off.

    Raises CannotRead where it told nothing.
    """
    device = walk.device
    if device is None or device.still is None:
        why = device.why if device else "only a capture of `terazi log --imu` holds it"
        raise CannotRead(
            f"{walk.name}: holds no zero velocity of a device: {why}",
            remedy="Choose another --detector: it finds where the foot stands from the samples.",
        )
    late = 0 if causal else min(round(device.late_s * walk.rate_hz), len(walk) - 1)
    still = np.concatenate([device.still[late:], np.repeat(device.still[-1:], late)])
    motion = np.where(still, STANDS, MOVES)
    return Detection(motion, np.ones(len(walk)), "0.5 stands, 2 moves", late / walk.rate_hz)
