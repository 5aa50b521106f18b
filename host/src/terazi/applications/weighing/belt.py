# SPDX-License-Identifier: MIT
"""A checkweigher's belt, simulated: what the load cell feels while products pass over it.

No recording of a real belt is open, so this is what results on dynamic weighing rest on; each
parameter is stated with its reason. Everything is drawn from one seed.

A product rolls on, lies wholly on the platform, and rolls off. The platform is a mass on a spring:
it passes most of the load on at once and rings with the rest, at a frequency that falls as the
load grows. The spring is another one for each product, so that one record stands for machines of
every stiffness: loaded tones are spread evenly (in octaves) over the whole range.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Belt:
    """All that a record depends on. Pairs are the bounds of what is drawn for each product."""

    seed: int = 2027
    products: int = 240
    weight_g: tuple[float, float] = (200.0, 1000.0)  # drawn evenly
    cycle_s: float = 0.5  # from product to product: 120 a minute
    cycle_jitter_s: float = 0.02  # +-: products never lie quite evenly on a belt
    platform_s: float = 0.3  # wholly on the platform
    ramp_s: tuple[float, float] = (0.04, 0.06)  # 40..60 mm of product at 1 m/s
    lead_s: float = 1.0  # empty belt before the first product and behind the last
    tone_hz: tuple[float, float] = (5.0, 20.0)  # of the loaded platform
    platform_g: float = 500.0  # swings along: 200 g and 1000 g of load differ by a factor of 1.46
    damping: tuple[float, float] = (0.02, 0.06)  # of the critical; steel with little rubber
    # A ramp is no step, and belts are set flush: most of the load comes on without a swing.
    swing_share: tuple[float, float] = (0.02, 0.08)  # of the load hangs on the spring
    # An edge between two belts: a half sine of 10 ms. It is what rings a stiff platform.
    bump_share: tuple[float, float] = (0.02, 0.08)  # of the load
    bump_s: float = 0.01
    # A roller that is not quite round: 30 mm across at 1 m/s turns 10.6 times a second, and its
    # bearings and the motor are above; the cell feels a few hundredths of a gram of each.
    vibrations_hz_g: tuple[tuple[float, float], ...] = ((10.6, 0.03), (24.3, 0.05))
    hum_hz: float = 50.0  # mains; the HX711 does not reject it at 80 SPS: it folds to 30 Hz
    hum_g: float = 0.1  # 0.23 uV of the 5 mV of full scale: a shielded cable
    rate_hz: float = 4000.0  # of the record: 20 Hz between its points bends by 1.2e-4 of a swing


@dataclass(frozen=True)
class Passage:
    """The truth of one product. Times in seconds of the record."""

    weight_g: float
    tone_hz: float  # of the platform under this product
    damping: float
    enters_s: float  # begins to roll on
    on_s: float  # lies wholly on the platform
    off_s: float  # begins to roll off
    leaves_s: float  # is gone


@dataclass(frozen=True)
class Record:
    """(n,) gram that the cell feels, (n,) gram that lie on it, at `rate_hz` from 0 s on."""

    belt: Belt
    load_g: np.ndarray
    truth_g: np.ndarray
    passages: tuple[Passage, ...]

    @property
    def duration_s(self) -> float:
        return len(self.load_g) / self.belt.rate_hz

    def at(self, times_s: np.ndarray) -> np.ndarray:
        """What the cell feels at any times, between the record's points as the bench has it."""
        return np.interp(times_s, np.arange(len(self.load_g)) / self.belt.rate_hz, self.load_g)


def passages(belt: Belt, random: np.random.Generator) -> tuple[Passage, ...]:
    """Draw what passes, and when."""
    drawn = []
    octaves = np.log2(belt.tone_hz)
    for index in range(belt.products):
        weight_g = random.uniform(*belt.weight_g)
        tone_hz = float(2 ** random.uniform(*octaves))
        ramp_s = random.uniform(*belt.ramp_s)
        jitter_s = random.uniform(-belt.cycle_jitter_s, belt.cycle_jitter_s)
        enters_s = belt.lead_s + index * belt.cycle_s + jitter_s
        on_s = enters_s + ramp_s
        off_s = on_s + belt.platform_s
        damping = random.uniform(*belt.damping)
        drawn.append(Passage(weight_g, tone_hz, damping, enters_s, on_s, off_s, off_s + ramp_s))
    return tuple(drawn)


def simulate(belt: Belt | None = None) -> Record:
    """Make the record."""
    belt = belt or Belt()
    random = np.random.default_rng(belt.seed)
    drawn = passages(belt, random)
    count = round((2 * belt.lead_s + belt.products * belt.cycle_s) * belt.rate_hz)
    times_s = np.arange(count) / belt.rate_hz
    truth_g, swing_g = np.zeros(count), np.zeros(count)
    at, state = 0, (0.0, 0.0)
    for index, passage in enumerate(drawn):
        following = drawn[index + 1].enters_s if index + 1 < len(drawn) else times_s[-1] + 1.0
        until = int(np.searchsorted(times_s, following))
        share = random.uniform(*belt.swing_share)
        bump = random.uniform(*belt.bump_share)
        here_s = times_s[at:until]
        knots_s = (passage.enters_s, passage.on_s, passage.off_s, passage.leaves_s)
        load_g = np.interp(here_s, knots_s, (0.0, passage.weight_g, passage.weight_g, 0.0))
        pushed_g = share * load_g
        for edge_s in (passage.enters_s, passage.off_s):
            phase = (here_s - edge_s) / belt.bump_s
            struck = (phase > 0.0) & (phase < 1.0)
            pushed_g += bump * passage.weight_g * struck * np.sin(np.pi * phase)
        truth_g[at:until] = load_g
        rung_g, state = _ring(belt, passage, load_g, pushed_g, state)
        swing_g[at:until] = rung_g - share * load_g
        at = until
    load_g = truth_g + swing_g
    for frequency_hz, amplitude_g in (*belt.vibrations_hz_g, (belt.hum_hz, belt.hum_g)):
        phase = random.uniform(0.0, 2 * np.pi)
        load_g += amplitude_g * np.sin(2 * np.pi * frequency_hz * times_s + phase)
    return Record(belt, load_g, truth_g, drawn)


def _ring(
    belt: Belt,
    passage: Passage,
    load_g: np.ndarray,
    pushed_g: np.ndarray,
    state: tuple[float, float],
) -> tuple[np.ndarray, tuple[float, float]]:
    """What the spring shows of the force `pushed_g`: q'' + 2 d w q' + w^2 (q - pushed) = 0.

    w^2 goes as 1 / (platform + load). Each step is exact for a force and a load that hold still
    over it; state is q and q'.
    """
    step_s = 1.0 / belt.rate_hz
    loaded_rad_s = 2 * np.pi * passage.tone_hz
    whole_g = belt.platform_g + passage.weight_g
    omega_rad_s = loaded_rad_s * np.sqrt(whole_g / (belt.platform_g + load_g))
    decay_s = passage.damping * omega_rad_s
    swing_rad_s = omega_rad_s * np.sqrt(1.0 - passage.damping**2)
    fade = np.exp(-decay_s * step_s)
    cosine, sine = np.cos(swing_rad_s * step_s), np.sin(swing_rad_s * step_s) / swing_rad_s
    # One step of (q - pushed, q') is a matrix of the free motion.
    from_q = fade * (cosine + decay_s * sine)
    from_speed = fade * sine
    speed_from_q = -fade * omega_rad_s**2 * sine
    speed_from_speed = fade * (cosine - decay_s * sine)
    q, speed = state
    rung_g = np.empty(len(load_g))
    columns = (pushed_g, from_q, from_speed, speed_from_q, speed_from_speed)
    for n, (push, a, b, c, d) in enumerate(zip(*(each.tolist() for each in columns), strict=True)):
        off = q - push
        q, speed = push + a * off + b * speed, c * off + d * speed
        rung_g[n] = q
    return rung_g, (q, speed)
