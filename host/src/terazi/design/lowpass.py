# SPDX-License-Identifier: MIT
"""A low-pass as it is wished for, by any method; what its quantised coefficients then do."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from terazi.design import equiripple, fir, notch, specs, windows

METHODS = ("frequency-sampling", *windows.WINDOWS, "equiripple")
TAPS_MAX = 64
# The least stop band that frequency sampling reaches, as in fir.toml: for a constant, and with one
# bin on the way down from a pass band.
TRANSITION_OF_CONSTANT, TRANSITION = (0.57, 0.08), (0.4,)
MAIN_LOBE_BINS = 3.0  # where a stop band can begin if nobody says so
SETTLED_WITHIN = 1e-4  # of a step
STOPBAND_POINTS = 4096
NOTCH_MAX_DB = -60.0
FLOOR_DB = -200.0  # beyond that a figure is rounding of float64


@dataclass(frozen=True)
class Wish:
    """What a filter shall do, at the rate that was measured."""

    method: str  # one of METHODS, or the name of a design of fir.toml
    rate_hz: float
    taps: int = 32
    pass_to_hz: float = 0.0  # 0: only a constant must pass
    stop_from_hz: float | None = None
    stop_max_db: float | None = None
    notches_hz: tuple[float, ...] = ()  # as in the world, not yet folded

    def checked(self) -> Wish:
        """Itself with what was left open filled in; ValueError where it makes no sense."""
        if not np.isfinite(self.rate_hz) or self.rate_hz <= 0:
            raise ValueError(f"a rate of {self.rate_hz} samples a second cannot be")
        entry = specs_entry(self.method)
        taps = entry["taps"] if entry else self.taps
        if not 2 <= taps <= TAPS_MAX:
            raise ValueError(f"2 to {TAPS_MAX} taps are possible, not {taps}")
        if any(not np.isfinite(each) or each <= 0 for each in self.notches_hz):
            raise ValueError("a notch is a frequency above 0 Hz")
        if not 0 <= self.pass_to_hz < self.rate_hz / 2:
            raise ValueError(f"a pass band to {self.pass_to_hz:g} Hz does not lie below half rate")
        stop_from_hz = self.stop_from_hz
        if stop_from_hz is None:
            stop_from_hz = self.pass_to_hz + MAIN_LOBE_BINS * self.rate_hz / taps
            if entry:  # its band is given at its nominal rate, and moves with the rate
                stop_from_hz = entry["stopband_from_hz"] * self.rate_hz / entry["nominal_rate_hz"]
            stop_from_hz = min(stop_from_hz, 0.45 * self.rate_hz)
        if not self.pass_to_hz < stop_from_hz < self.rate_hz / 2:
            raise ValueError(
                f"the stop band must begin above the pass band and below {self.rate_hz / 2:g} Hz, "
                f"not at {stop_from_hz:g} Hz"
            )
        return Wish(
            self.method,
            self.rate_hz,
            taps,
            self.pass_to_hz,
            stop_from_hz,
            self.stop_max_db,
            self.notches_hz,
        )


def specs_entry(method: str) -> dict | None:
    """The design of fir.toml of that name, if it is one."""
    return next((each for each in specs.fir_designs() if each["name"] == method), None)


@dataclass(frozen=True)
class Filter:
    """Quantised coefficients, and the wish that they come from."""

    wish: Wish
    taps_q15: np.ndarray
    figures: Figures = field(repr=False)

    @property
    def name(self) -> str:
        return f"{self.wish.method}, {len(self.taps_q15)} taps"


@dataclass(frozen=True)
class Figures:
    """What the quantised coefficients do."""

    noise_gain: float  # standard deviation out over in, white noise
    delay_s: float
    settling_s: float  # of a step, to 1e-4
    overshoot: float  # of a step
    pass_min_db: float  # at the pass band's end; 0 where only a constant passes
    stop_max_db: float
    stop_max_db_before: float  # the same before the coefficients were quantised
    notches_db: dict[float, float]  # by frequency in the world
    misses: tuple[str, ...]  # of the wish; empty where it is met


def design(wish: Wish) -> Filter:
    """Coefficients for a wish; ValueError where there are none."""
    wish = wish.checked()
    response = _response(wish)
    if wish.notches_hz:
        response = notch.with_notches(response, wish.notches_hz, wish.rate_hz)
    taps_q15 = fir.quantise_q15(response)
    return Filter(wish, taps_q15, figures(taps_q15, wish, response))


def _response(wish: Wish) -> np.ndarray:
    method, taps, rate_hz = wish.method, wish.taps, wish.rate_hz
    if specs_entry(method):
        return specs.fir_taps(method)
    if method == "frequency-sampling":
        bins = int(np.ceil(wish.pass_to_hz * taps / rate_hz - 1e-9)) + 1
        slope = TRANSITION if bins > 1 else TRANSITION_OF_CONSTANT
        room = (taps + 1) // 2
        return fir.frequency_sampling(taps, ([1.0] * bins + list(slope))[:room])
    if method in windows.WINDOWS:
        middle_hz = (wish.pass_to_hz + wish.stop_from_hz) / 2 if wish.pass_to_hz else 0.0
        return windows.lowpass(method, taps, middle_hz, rate_hz)
    if method == "equiripple":
        return equiripple.lowpass(taps, wish.pass_to_hz, wish.stop_from_hz, rate_hz)
    known = [*METHODS, *(each["name"] for each in specs.fir_designs())]
    raise ValueError(f"no method {method!r}; there are {', '.join(known)}")


def level_db(coefficients, frequencies_hz, rate_hz) -> np.ndarray:
    """Gain at frequencies of the world, folded, in dB, no lower than a figure can mean."""
    folded = notch.folded_hz(frequencies_hz, rate_hz)
    return np.maximum(fir.magnitude_db(coefficients, folded, rate_hz), FLOOR_DB)


def figures(taps_q15, wish: Wish, response) -> Figures:
    """What coefficients do, held against a wish that was checked."""
    rate_hz = wish.rate_hz
    band_hz = np.linspace(wish.stop_from_hz, rate_hz / 2, STOPBAND_POINTS)
    stop_max_db = float(level_db(taps_q15, band_hz, rate_hz).max())
    depths = level_db(taps_q15, wish.notches_hz, rate_hz) if wish.notches_hz else []
    notches_db = dict(zip(wish.notches_hz, map(float, depths), strict=True))
    misses = [
        f"the notch at {hz:g} Hz has {depth:.1f} dB, not {NOTCH_MAX_DB:g} dB"
        for hz, depth in notches_db.items()
        if depth > NOTCH_MAX_DB
    ]
    if wish.stop_max_db is not None and stop_max_db > wish.stop_max_db:
        misses.append(
            f"the stop band from {wish.stop_from_hz:.4g} Hz has {stop_max_db:.1f} dB, "
            f"not {wish.stop_max_db:g} dB"
        )
    step = np.cumsum(taps_q15) / taps_q15.sum()
    return Figures(
        noise_gain=fir.noise_gain(taps_q15),
        delay_s=fir.delay_samples(taps_q15) / rate_hz,
        settling_s=fir.settling_samples(taps_q15, SETTLED_WITHIN) / rate_hz,
        overshoot=max(0.0, float(step.max() - 1)),
        pass_min_db=float(level_db(taps_q15, [wish.pass_to_hz], rate_hz)[0]),
        stop_max_db=stop_max_db,
        stop_max_db_before=float(level_db(response, band_hz, rate_hz).max()),
        notches_db=notches_db,
        misses=tuple(misses),
    )
