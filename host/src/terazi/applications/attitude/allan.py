# SPDX-License-Identifier: MIT
"""Allan deviation of a standstill, and the noise figures that are read off it.

With the overlapping estimate (allantools), per axis, for rates in deg/s and accelerations in g:

    white noise N      sigma = N / sqrt(tau): where the curve falls so; angle or velocity random
                       walk. A datasheet's density is one-sided, sqrt(2) N.
    instability B      sigma = B sqrt(2 ln 2 / pi): where it is flat, else its least
    random walk K      sigma = K sqrt(tau / 3): where it rises so

after IEEE Std 952-1997, annex C. A figure is given only where the curve shows it: one that still
falls at its end has its instability below what is seen there. Averages of more than a ninth of
the record are not read off: a point of 9 has an error of 25 %.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from terazi.applications.attitude.records import GRAVITY_M_S2, Record
from terazi.errors import CannotRead, UsageError

AXES = ("x", "y", "z")
SHORTEST_S = 60.0
POINTS_AN_OCTAVE = 4
READ_SHARE = 9  # of the record, at most
SHOWN_SHARE = 3
FLAT = math.sqrt(2 * math.log(2) / math.pi)  # 0.664
SLOPE_WITHIN = 0.12
SLOPE_OVER = 2  # points on either side
STILL_FALLS = -0.25
SURE_SIGMAS = 4.0
HOUR_S = 3600.0

BLOCK_S = 1.0
BLOCKS_APART = 2  # what changes between them moves; a bias that warms up is slower
MOVES_DEG_S, MOVES_G = 0.5, 0.010
LOUDER = 4.0  # than the median second: knocks

# PS-MPU-6000A-00 rev 3.4, pp. 12, 13: densities at 10 Hz, one-sided
DATASHEET_GYRO_DEG_S_RTHZ = 0.005
DATASHEET_ACC_G_RTHZ = 400e-6


@dataclass(frozen=True)
class Axis:
    """One axis' curve and figures, in deg/s or g, with seconds."""

    tau_s: np.ndarray
    deviation: np.ndarray
    error: np.ndarray  # one sigma of each, 1 / sqrt(2 (T / tau - 1)) of it (IEEE Std 952)
    white: float | None  # N, times sqrt(s)
    instability: float  # B, or what it lies below
    instability_tau_s: float
    instability_is_seen: bool
    walk: float | None  # K, a sqrt(s)

    @property
    def density(self) -> float | None:
        """One-sided, as datasheets have it, a sqrt(Hz)."""
        return None if self.white is None else math.sqrt(2) * self.white


@dataclass(frozen=True)
class Allan:
    """Both sensors of one record."""

    name: str
    duration_s: float
    rate_hz: float
    gyro: dict[str, Axis]  # deg/s
    acc: dict[str, Axis]  # g
    notes: list[str] = field(default_factory=list)

    def plain(self) -> dict:
        """What `terazi attitude allan --json` prints."""
        return {
            "name": self.name,
            "duration_s": self.duration_s,
            "rate_hz": self.rate_hz,
            "gyro": {name: _plain_gyro(axis) for name, axis in self.gyro.items()},
            "acc": {name: _plain_acc(axis) for name, axis in self.acc.items()},
            "datasheet": {
                "gyro_density_deg_s_rthz": DATASHEET_GYRO_DEG_S_RTHZ,
                "angle_random_walk_deg_rth": DATASHEET_GYRO_DEG_S_RTHZ / math.sqrt(2) * 60,
                "acc_density_ug_rthz": DATASHEET_ACC_G_RTHZ * 1e6,
                "velocity_random_walk_m_s_rth": velocity_walk(DATASHEET_ACC_G_RTHZ / math.sqrt(2)),
            },
            "notes": self.notes,
        }


def velocity_walk(white_g: float) -> float:
    """N of an accelerometer, g sqrt(s), as m/s a sqrt(h)."""
    return white_g * GRAVITY_M_S2 * math.sqrt(HOUR_S)


def _plain_gyro(axis: Axis) -> dict:
    white, walk = axis.white, axis.walk
    return {
        "density_deg_s_rthz": axis.density,
        "angle_random_walk_deg_rth": None if white is None else white * math.sqrt(HOUR_S),
        "bias_instability_deg_h": axis.instability * HOUR_S,
        "bias_instability_is_seen": axis.instability_is_seen,
        "bias_instability_tau_s": axis.instability_tau_s,
        "rate_random_walk_deg_h_rth": None if walk is None else walk * HOUR_S**1.5,
        **_plain_curve(axis),
    }


def _plain_acc(axis: Axis) -> dict:
    white, walk = axis.white, axis.walk
    return {
        "density_ug_rthz": None if white is None else axis.density * 1e6,
        "velocity_random_walk_m_s_rth": None if white is None else velocity_walk(white),
        "bias_instability_ug": axis.instability * 1e6,
        "bias_instability_is_seen": axis.instability_is_seen,
        "bias_instability_tau_s": axis.instability_tau_s,
        "acceleration_random_walk_ug_rts": None if walk is None else walk * 1e6,
        **_plain_curve(axis),
    }


def _plain_curve(axis: Axis) -> dict:
    return {
        name: [float(f"{value:.5g}") for value in getattr(axis, name)]
        for name in ("tau_s", "deviation", "error")
    }


def allan(record: Record) -> Allan:
    """Both sensors of a standstill. Raises CannotRead: gaps, too short, moves, a dead axis;
    UsageError where allantools is missing."""
    notes = []
    stretches = record.whole_stretches()
    if len(stretches) > 1:
        first, last = max(stretches, key=lambda one: one[1] - one[0])
        seconds = record.t_s
        notes.append(
            f"samples are missing at {len(stretches) - 1} places: read is the longest stretch "
            f"without, from {seconds[first]:.1f} to {seconds[last - 1]:.1f} s"
        )
        record = record.part(first, last)
    refuse(record)
    if record.every > 1:
        notes.append(
            f"one in {record.every} samples was recorded: what is faster folds into the noise, and "
            "white noise reads too high; imu.every=1 records all"
        )
    return Allan(
        name=record.name,
        duration_s=len(record) / record.rate_hz,
        rate_hz=record.rate_hz,
        gyro=_axes(record.rate_b_deg_s, record.rate_hz),
        acc=_axes(record.acc_b_g, record.rate_hz),
        notes=notes,
    )


def refuse(record: Record) -> None:
    """Raises CannotRead where no Allan deviation of a standstill can come of it."""
    seconds = len(record) / record.rate_hz
    if seconds < SHORTEST_S:
        raise CannotRead(
            f"{record.name}: {seconds:.1f} s without a gap are too short",
            remedy=f"{SHORTEST_S:g} s tell white noise; bias instability wants an hour or more.",
        )
    sensors = (
        ("gyroscope", record.rate_b_deg_s, MOVES_DEG_S, "deg/s"),
        ("accelerometer", record.acc_b_g, MOVES_G, "g"),
    )
    for name, values, limit, unit in sensors:
        dead = [axis for axis, column in zip(AXES, values.T, strict=True) if np.ptp(column) == 0]
        if dead:
            raise CannotRead(
                f"{record.name}: the {name} gives one and the same value on {', '.join(dead)}",
                remedy="A sensor that works has noise. Is it asleep, or a made-up recording?",
            )
        moved = _moves(values, record.rate_hz, limit)
        if moved is not None:
            at_s, by, how = moved
            raise CannotRead(
                f"{record.name} moves: at {at_s:.0f} s the {name} {how} by {by:.3g} {unit}",
                remedy="Let the board lie on something heavy, and cut the hands off its ends with "
                "--begin and --end.",
            )


def _moves(values: np.ndarray, rate_hz: float, limit: float) -> tuple[float, float, str] | None:
    """The first second that is no standstill: when, by how much, how."""
    size = round(BLOCK_S * rate_hz)
    blocks = values[: len(values) // size * size].reshape(-1, size, 3)
    means, spreads = blocks.mean(axis=1), blocks.std(axis=1)
    away = np.zeros(len(means))
    away[BLOCKS_APART:] = np.abs(means[BLOCKS_APART:] - means[:-BLOCKS_APART]).max(axis=1)
    loud = (spreads - LOUDER * np.median(spreads, axis=0)).max(axis=1)
    for wrong, size_of, how in ((away > limit, away, "changes"), (loud > limit, loud, "shakes")):
        if wrong.any():
            at = int(np.argmax(wrong))
            return at * BLOCK_S, float(size_of[at]), how
    return None


def _axes(values: np.ndarray, rate_hz: float) -> dict[str, Axis]:
    return {name: axis_of(column, rate_hz) for name, column in zip(AXES, values.T, strict=True)}


def axis_of(values: np.ndarray, rate_hz: float) -> Axis:
    """The curve of one axis, and what it shows.

    values : (n,) at a steady rate.
    """
    try:
        import allantools
    except ImportError:
        raise UsageError(
            "the Allan deviation needs allantools", remedy="Install it: pip install 'terazi[allan]'"
        ) from None

    counts = _clusters(len(values))
    # allantools' own error takes overlapping averages for independent ones.
    tau_s, deviation, _error, _n = allantools.oadev(
        values - values.mean(), rate=rate_hz, data_type="freq", taus=counts / rate_hz
    )
    error = deviation / np.sqrt(2 * (len(values) / rate_hz / tau_s - 1))
    return read_off(tau_s, deviation, error, len(values) / rate_hz)


def _clusters(samples: int) -> np.ndarray:
    """Sample numbers of an average, evenly in the logarithm."""
    most = samples // SHOWN_SHARE
    exponents = np.arange(0.0, math.log2(most), 1.0 / POINTS_AN_OCTAVE)
    return np.unique(np.rint(2.0**exponents).astype(np.int64))


def read_off(tau_s, deviation, error, duration_s: float) -> Axis:
    """The figures of one curve."""
    readable = tau_s <= duration_s / READ_SHARE
    tau, sigma = tau_s[readable], deviation[readable]
    weight = (sigma / error[readable]) ** 2
    slope = local_slopes(tau, sigma)
    least = int(np.argmin(sigma))
    white = _read(tau, slope, -0.5, np.log(sigma * np.sqrt(tau)), weight)
    late = slice(least, None)
    walk = _read(
        tau[late], slope[late], 0.5, np.log(sigma[late] * np.sqrt(3 / tau[late])), weight[late]
    )
    if white is None:
        is_seen = bool(slope[least:].max() > STILL_FALLS)
    else:  # where chance does not explain what white noise alone leaves
        more = sigma - white / np.sqrt(tau)
        is_seen = bool((more > SURE_SIGMAS * error[readable])[tau >= 1.0].any())
    flat = _read(tau, slope, 0.0, np.log(sigma), weight)
    return Axis(
        tau_s=tau_s,
        deviation=deviation,
        error=error,
        white=white,
        instability=(float(sigma[least]) if flat is None else flat) / FLAT,
        instability_tau_s=float(tau[least]),
        instability_is_seen=is_seen,
        walk=walk,
    )


def local_slopes(tau: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """d log sigma / d log tau at each point, by a line through it and its neighbours."""
    x, y = np.log(tau), np.log(sigma)
    slopes = np.empty(len(x))
    for at in range(len(x)):
        near = slice(max(0, at - SLOPE_OVER), at + SLOPE_OVER + 1)
        away = x[near] - x[near].mean()
        slopes[at] = away @ y[near] / (away @ away)
    return slopes


def _read(tau, slope, wanted: float, log_value, weight) -> float | None:
    """The value where the curve has the wanted slope, over the longest such run of an octave or
    more; None where there is none."""
    fits = np.concatenate([[False], np.abs(slope - wanted) < SLOPE_WITHIN, [False]])
    edges = np.flatnonzero(np.diff(fits))
    runs = [
        (math.log2(tau[last - 1] / tau[first]), first, last)
        for first, last in zip(edges[::2], edges[1::2], strict=True)
    ]
    octaves, first, last = max(runs, default=(0.0, 0, 0))
    if octaves < 1:
        return None
    part = slice(first, last)
    return float(np.exp(np.average(log_value[part], weights=weight[part])))
