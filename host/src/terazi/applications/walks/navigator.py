# SPDX-License-Identifier: MIT
"""Navigator (b): strapdown integration and an error-state Kalman filter (cshared.Ins).

Where the foot stands, its velocity is zero: a pseudo-measurement whose sigma grows with the
detector's doubt. Where it stands for long, its angular rate is zero as well, which is how the
gyroscope's bias becomes known. And a floor is level: a foot that comes to stand within
`level_gate_m` of the height where it stood before is taken to stand on the same floor; one that
stands higher or lower than that has climbed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from terazi.applications.walks.clipping import AHEAD_S
from terazi.applications.walks.detectors import Detection
from terazi.applications.walks.record import Walk
from terazi.applications.walks.windows import moving_variance, odd_length
from terazi.cshared import Ins

GRAVITY_M_S2 = 9.81
HELD_M = 0.0095  # what the future may change of a position: of strides 1 % longer, too, within 1 cm
REVISED_EVERY_S = 0.1  # a decision that turns out otherwise waits no longer
GLIDE_S = 0.05  # in which a path that learns better forgets where it was, to a third
UNKNOWN_TILT_RAD, UNKNOWN_M_S = 0.5, 1.0  # 1 sigma, of a record that begins in motion


@dataclass(frozen=True)
class KalmanSettings:
    """Sigmas are of one sample at 200 Hz where they are of a measurement; of the state after a
    second where they are noises."""

    vel_sigma_m_s: float = 0.066
    vel_doubt: float = 4.3  # variance x (1 + vel_doubt x doubt)
    rate_sigma_rad_s: float = 0.03  # in a standstill
    stance_rate_sigma_rad_s: float = 0.6  # in every stance; 0: not used
    standstill_s: float = 0.45  # of quiet that make a stance a standstill
    standstill_rad_s: float = 0.02  # the rate's spread in it
    level_sigma_m: float = 0.012
    level_gate_m: float = 0.08  # 0: floors are not level
    level_after_s: float = 0.04  # of a stance
    gate_sigmas: float = 0.0  # innovations beyond count less; 0: never
    attitude_noise_rad: float = 0.0063
    velocity_noise_m_s: float = 0.0114
    gyro_bias_noise_rad_s: float = 6e-6
    acc_bias_noise_m_s2: float = 0.0026
    attitude_sigma_rad: float = 0.02
    gyro_bias_sigma_rad_s: float = 0.004
    acc_bias_sigma_m_s2: float = 0.23
    gyro_scale_sigma: float = 0.0  # any of these three: 24 states
    acc_scale_sigma: float = 0.0
    gravity_sigma_m_s2: float = 0.0
    align_s: float = 0.35  # over which the first acceleration is averaged
    smooth_s: float = 0.25  # of the future, at least; 0: a filter
    held_m: float = HELD_M


CAUSAL = KalmanSettings(
    vel_sigma_m_s=0.066,
    vel_doubt=12.0,
    rate_sigma_rad_s=0.036,
    stance_rate_sigma_rad_s=0.4,
    standstill_s=0.2,
    standstill_rad_s=0.0084,
    level_sigma_m=0.01,
    level_after_s=0.05,
    attitude_noise_rad=0.019,
    velocity_noise_m_s=0.004,
    gyro_bias_noise_rad_s=2e-5,
    acc_bias_noise_m_s2=0.0014,
    gyro_bias_sigma_rad_s=0.0027,
    acc_bias_sigma_m_s2=0.107,
    align_s=0.125,
    smooth_s=0.0,
)
"""For decisions that are made at once and never revised, as a device makes them."""


@dataclass(frozen=True)
class Path:
    """What a navigator makes of a walk; world axes, z up, heading from 0."""

    pos_w_m: np.ndarray  # (n, 3)
    vel_w_m_s: np.ndarray  # (n, 3)
    quat_wb: np.ndarray  # (n, 4)
    still: np.ndarray  # (n,) bool
    settled: int  # first samples, which a longer record would not change


def standstill(walk: Walk, still: np.ndarray, settings: KalmanSettings, *, causal: bool):
    """(n,) bool: in a stance, and quiet for standstill_s."""
    length = odd_length(settings.standstill_s, walk.rate_hz)
    spread = moving_variance(walk.gyro_b_rad_s, length, causal=causal)
    return still & (spread < settings.standstill_rad_s**2)


def stance_ages(still: np.ndarray) -> np.ndarray:
    """(n,) samples since a stance began, 1 at its first; 0 in between."""
    count = np.cumsum(still)
    before = np.maximum.accumulate(np.where(still, 0, count))
    return np.where(still, count - before, 0)


def upright(acc_b: np.ndarray) -> np.ndarray:
    """The attitude, heading 0, in which this force points up."""
    x, y, up = acc_b / np.linalg.norm(acc_b)
    if up >= 0:
        larger = np.sqrt((1 + up) / 2)
        return np.array([larger, y / (2 * larger), -x / (2 * larger), 0.0])
    larger = np.sqrt((1 - up) / 2)
    return np.array([y / (2 * larger), larger, 0.0, x / (2 * larger)])


def kalman(
    walk: Walk,
    detection: Detection,
    settings: KalmanSettings,
    *,
    causal: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Run it; causal: each sample as it is known at that sample.

    Decisions that are revised later (`detection.at_once`) are revised in a causal run, too: the
    filter goes back to where it knew better. A recorded walk is smoothed from there, but no
    position moves by more than `held_m` from what was known of it at once: so whatever is cut off
    a record's end, the rest stays where it is. (Unless decisions know the whole record, ahead_s
    infinite: then nothing can be held.)
    """
    known_rates, rates_at_once = walk.rates.known_b_rad_s, walk.rates.at_once_b_rad_s
    at_once = detection.at_once
    told = None
    if at_once is not None and (causal or np.isfinite(detection.ahead_s)):
        begins = detection if np.isfinite(detection.ahead_s) else at_once
        told = _ins(walk, begins, settings).run_at_once(
            *(walk.dt_s, walk.acc_b_m_s2),
            (rates_at_once, *_sigmas(walk, at_once, settings, causal=True)),
            (known_rates, *_sigmas(walk, detection, settings, causal=False)),
            revised_after=len(walk) - _revised(walk, detection, settings),
            piece=revised_piece(walk),
            progress=_share(progress, 0.0, 1.0 if causal else 0.5),
        )
        told[:, :3] = glided(told[:, :3], told[:, 3:6], walk.dt_s)
    if causal and told is not None:
        return _path(told, at_once.still, len(walk))
    smooth_len = 0 if causal else round(settings.smooth_s * walk.rate_hz)
    rows, _biases = _ins(walk, detection, settings).run(
        *(walk.dt_s, walk.acc_b_m_s2, rates_at_once if causal else known_rates),
        *_sigmas(walk, detection, settings, causal=causal),
        smooth_len=smooth_len,
        progress=progress if told is None else _share(progress, 0.5, 1.0),
    )
    known = len(walk) if causal else _revised(walk, detection, settings)
    if smooth_len:
        known = max(0, known // smooth_len - 1) * smooth_len
    if told is not None:
        rows[:known, :3] = held(told[:known, :3], rows[:known, :3], settings.held_m)
        rows[known:] = told[known:]
    return _path(rows, detection.still, known)


def glided(pos_m: np.ndarray, vel_m_s: np.ndarray, dt_s: np.ndarray) -> np.ndarray:
    """(n, 3) without the leaps that its velocity does not explain: it glides to where it leapt to.

    Of sample i it depends on samples 0 .. i alone.
    """
    leaps = np.diff(pos_m, axis=0) - (vel_m_s[1:] + vel_m_s[:-1]) / 2 * dt_s[1:, None]
    keeps = np.exp(-dt_s[1:] / GLIDE_S).tolist()
    behind = np.zeros_like(pos_m)
    for axis in range(3):
        late, column = 0.0, [0.0]
        for leap, keep in zip(leaps[:, axis].tolist(), keeps, strict=True):
            late = (late + leap) * keep
            column.append(late)
        behind[:, axis] = column
    return pos_m - behind


def held(told_m: np.ndarray, known_m: np.ndarray, most_m: float) -> np.ndarray:
    """(n, 3) what is known now, but no farther than most_m from what was told at once."""
    change = known_m - told_m
    size = np.linalg.norm(change, axis=1, keepdims=True)
    share = np.minimum(most_m / np.maximum(size, 1e-9), 1.0)
    return np.where(share < 1, told_m + share * change, known_m)


def revised_piece(walk: Walk) -> int:
    """Samples after which decisions are revised."""
    return max(1, round(REVISED_EVERY_S * walk.rate_hz))


def _path(rows: np.ndarray, still: np.ndarray, settled: int) -> Path:
    return Path(rows[:, :3], rows[:, 3:6], rows[:, 6:], still, settled)


def _revised(walk: Walk, detection: Detection, settings: KalmanSettings) -> int:
    return final_samples(walk, max(settings.standstill_s / 2, detection.ahead_s, AHEAD_S))


def _share(progress, begin: float, end: float):
    return progress and (lambda share: progress(begin + (end - begin) * share))


def _sigmas(walk: Walk, detection: Detection, settings: KalmanSettings, *, causal: bool):
    """Three (n,) of zero velocity, zero angular rate and unchanged height; 0 where there is none.

    The pseudo-measurements' errors last longer than a sample: at other rates there are more or
    fewer of them for the same knowledge.
    """
    still = detection.still
    per_sample = np.sqrt(walk.rate_hz / 200.0)
    vel_sigma = settings.vel_sigma_m_s * per_sample
    vel = np.where(still, vel_sigma * np.sqrt(1 + settings.vel_doubt * detection.doubt), 0.0)
    quiet = standstill(walk, still, settings, causal=causal)
    rate = np.where(still, settings.stance_rate_sigma_rad_s * per_sample, 0.0)
    rate = np.where(quiet, settings.rate_sigma_rad_s * per_sample, rate)
    level = np.zeros(len(walk))
    if settings.level_gate_m > 0:
        after = max(1, round(settings.level_after_s * walk.rate_hz))
        level[stance_ages(still) == after] = settings.level_sigma_m
    return vel, rate, level


def _ins(walk: Walk, detection: Detection, settings: KalmanSettings) -> Ins:
    """The filter as a record begins: as much of it is averaged as its first sample waits for."""
    first = slice(0, max(1, round(settings.align_s * walk.rate_hz)))
    stands = np.mean(detection.still[first]) > 0.5
    tilt = settings.attitude_sigma_rad if stands else UNKNOWN_TILT_RAD
    return Ins(
        upright(walk.acc_b_m_s2[first].mean(axis=0)),
        sigmas={
            "velocity": 1e-3 if stands else UNKNOWN_M_S,
            "attitude": (tilt, tilt, 0.0),
            "gyro_bias": settings.gyro_bias_sigma_rad_s,
            "acc_bias": settings.acc_bias_sigma_m_s2,
            "gyro_scale": settings.gyro_scale_sigma,
            "acc_scale": settings.acc_scale_sigma,
            "gravity": (0.0, 0.0, settings.gravity_sigma_m_s2),
        },
        noises={
            "velocity": settings.velocity_noise_m_s,
            "attitude": settings.attitude_noise_rad,
            "gyro_bias": settings.gyro_bias_noise_rad_s,
            "acc_bias": settings.acc_bias_noise_m_s2,
        },
        gravity_m_s2=GRAVITY_M_S2,
        gate_sigmas=settings.gate_sigmas,
        level_gate_m=settings.level_gate_m,
    )


def rolled(path: Path, share: float) -> Path:
    """The path with what the foot rolls ahead in each stance, where zero velocity denies it."""
    wider = np.array([1 + share, 1 + share, 1.0])
    return replace(path, pos_w_m=path.pos_w_m * wider, vel_w_m_s=path.vel_w_m_s * wider)


def final_samples(walk: Walk, ahead_s: float) -> int:
    """How many samples' windows lie within the record."""
    if not np.isfinite(ahead_s):
        return 0
    return max(0, len(walk) - int(np.ceil(ahead_s * walk.rate_hz)) - 2)
