# SPDX-License-Identifier: MIT
"""The filters that scales commonly have, as judges of a checkweigher's estimator.

Each sees what is best for it: all masses while the product lies wholly on the platform, which only
a simulation can tell, and nothing of the ramps. What it says with the last of them is its weight.
Recursive ones start at the first mass they see, as if the product had always lain there. Each has
the setting, of many, that had the least sigma on products of other seeds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

Filter = Callable[[np.ndarray], np.ndarray]
"""(products, n) masses, oldest first, to (products,) weights."""

SKIPPED = (0, 4, 8)  # masses at the begin that a recursive filter is spared
SHARES = (0.03, 0.05, 0.08, 0.12, 0.2, 0.3, 0.5)
CUTOFFS_HZ = (0.5, 0.8, 1.2, 1.8, 2.7, 4.0, 6.0)
BETAS = (0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0)  # of Kaiser's window: 0 is a plain mean
FIR_CUTOFFS_HZ = (0.0, 2.0, 4.0, 6.0, 8.0)  # 0: the window alone
SHORTEST = 6

# Analogue prototypes with their edge at 1 rad/s, 3 dB down: the poles of the upper half plane.
BUTTERWORTH = {
    order: tuple(
        complex(np.exp(1j * np.pi * (0.5 + (2 * k + 1) / (2 * order)))) for k in range(order // 2)
    )
    for order in (2, 4)
}
BESSEL = {  # reverse Bessel polynomials, divided by their 3 dB edges 1.3617 and 2.1139
    2: ((-1.5 + 0.8660254j) / 1.36165413,),
    4: (
        (-2.89621060 + 0.86723413j) / 2.11391767,
        (-2.10378940 + 2.65741804j) / 2.11391767,
    ),
}


@dataclass(frozen=True)
class Peer:
    """A filter with its setting in words."""

    setting: str
    run: Filter


def weighted(weights: np.ndarray) -> Filter:
    """A FIR of unit gain at 0 Hz, over the last masses."""
    share = weights / weights.sum()
    return lambda masses: masses[:, -len(share) :] @ share


def median(length: int) -> Filter:
    return lambda masses: np.median(masses[:, -length:], axis=1)


def exponential(share: float, skipped: int) -> Filter:
    def run(masses: np.ndarray) -> np.ndarray:
        value = masses[:, skipped].copy()
        for column in masses[:, skipped + 1 :].T:
            value += share * (column - value)
        return value

    return run


def recursive(poles: tuple[complex, ...], cutoff_hz: float, rate_hz: float, skipped: int) -> Filter:
    """Second-order sections by the bilinear transform, the edge kept where it was."""
    edge = np.tan(np.pi * cutoff_hz / rate_hz)
    sections = []
    for pole in poles:
        linear, square = -2 * pole.real * edge, abs(pole) ** 2 * edge**2
        scale = 1.0 + linear + square
        sections.append((square / scale, 2 * (square - 1) / scale, (1 - linear + square) / scale))

    def run(masses: np.ndarray) -> np.ndarray:
        signal = masses[:, skipped:]
        for gain, a1, a2 in sections:
            x1 = x2 = y1 = y2 = signal[:, 0]
            made = np.empty_like(signal)
            for n, x in enumerate(signal.T):
                y = gain * (x + 2 * x1 + x2) - a1 * y1 - a2 * y2
                x1, x2, y1, y2 = x, x1, y, y1
                made[:, n] = y
            signal = made
        return signal[:, -1]

    return run


def _fir(length: int, rate_hz: float) -> Iterator[Peer]:
    at = np.arange(length) - (length - 1) / 2
    for beta in BETAS:
        for cutoff_hz in FIR_CUTOFFS_HZ:
            weights = np.kaiser(length, beta) * np.sinc(2 * cutoff_hz * at / rate_hz)
            if weights.sum() > 0.1 * length:
                yield Peer(f"{length} taps, beta {beta:g}, {cutoff_hz:g} Hz", weighted(weights))


def families(length: int, rate_hz: float) -> dict[str, list[Peer]]:
    """All settings of each family, for `length` masses at rate_hz."""
    lengths = range(SHORTEST, length + 1)
    return {
        "moving_average": [Peer(f"{n} masses", weighted(np.ones(n))) for n in lengths],
        "median": [Peer(f"{n} masses", median(n)) for n in lengths],
        "exponential": [
            Peer(f"share {share:g} after {skipped}", exponential(share, skipped))
            for share in SHARES
            for skipped in SKIPPED
        ],
        **{
            name: [
                Peer(
                    f"order {order}, {cutoff_hz:g} Hz after {skipped}",
                    recursive(poles, cutoff_hz, rate_hz, skipped),
                )
                for order, poles in prototypes.items()
                for cutoff_hz in CUTOFFS_HZ
                for skipped in SKIPPED
            ]
            for name, prototypes in {"butterworth": BUTTERWORTH, "bessel": BESSEL}.items()
        },
        "fir_lowpass": [peer for n in lengths for peer in _fir(n, rate_hz)],
    }


def best(
    settings: Mapping[str, list[Peer]], masses: np.ndarray, weights: np.ndarray
) -> dict[str, Peer]:
    """Of each family the setting with the least sigma on these products."""

    def sigma(peer: Peer) -> float:
        return float(np.std(peer.run(masses) - weights))

    return {name: min(peers, key=sigma) for name, peers in settings.items()}
