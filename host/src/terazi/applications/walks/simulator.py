# SPDX-License-Identifier: MIT
"""A foot that walks, with its exact path: for tests that need no recordings.

Motion is made of polynomials that join with four continuous derivatives, so acceleration and
angular rate are written down, not differenced. Samples are those of the middle of each interval,
the truth that of its end, which is what a converter's mean over the interval comes to.
A stride lifts the heel (the foot pitches down by about a radian), swings, and comes to stand toe
up. In a stance the foot may rock a little about its sole: no detector's paradise. It does not roll
ahead, as a real one does: for this foot `Options.roll_share` is 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from terazi.applications.walks.navigator import upright
from terazi.applications.walks.record import Truth, Walk

GRAVITY_M_S2 = 9.81
SOLE_M = 0.08  # the sensor above what it rocks about


@dataclass(frozen=True)
class Gait:
    """How strides look."""

    length_m: float
    swing_s: float
    stance_s: float
    lift_m: float
    pitch_rad: float
    rock_rad: float = 0.01


WALKING = Gait(1.35, 0.52, 0.58, 0.10, 1.0)
RUNNING = Gait(2.2, 0.46, 0.24, 0.18, 1.2, 0.015)
STAIRS = Gait(0.56, 0.60, 0.60, 0.12, 0.5)


@dataclass(frozen=True)
class Motion:
    """One piece: where the foot goes in it, and how. All zero: it stands."""

    duration_s: float
    ahead_m: float = 0.0  # along the heading half way through the turn
    up_m: float = 0.0
    turn_rad: float = 0.0
    lift_m: float = 0.0
    pitch_rad: float = 0.0
    rock_rad: float = 0.0


@dataclass(frozen=True)
class Mems:
    """Errors of the sensor, about those of an MPU-6050 whose bias was once calibrated."""

    gyro_bias_rad_s: float = 0.005  # 1 sigma, drawn once a walk
    acc_bias_m_s2: float = 0.05
    gyro_noise_rad_s: float = 0.0015  # of a sample at 200 Hz
    acc_noise_m_s2: float = 0.06
    gyro_scale: float = 0.003  # 1 sigma, each axis
    acc_scale: float = 0.003
    gyro_walk_rad_s: float = 2e-5  # gained in a second
    gyro_range_rad_s: float = np.radians(2000.0)
    acc_range_m_s2: float = 16 * 9.81
    impact_m_s2: float = 15.0  # where a foot comes down: 55 Hz, gone in 60 ms


PERFECT = Mems(0, 0, 0, 0, 0, 0, 0, np.inf, np.inf, 0)


def stand(seconds: float) -> list[Motion]:
    """Nothing moves."""
    return [Motion(seconds)]


def strides(
    count: int,
    gait: Gait = WALKING,
    *,
    turn_rad: float = 0.0,
    up_m: float = 0.0,
    rng: np.random.Generator | None = None,
) -> list[Motion]:
    """So many strides, each followed by its stance; each turns and climbs by that much.

    rng : lengths and times then differ by some per cent, as a person's do.
    """
    pieces = []
    for _ in range(count):
        vary = 1 + (0.04 * rng.standard_normal(3).clip(-2, 2) if rng else np.zeros(3))
        pieces.append(
            Motion(
                gait.swing_s * vary[0],
                gait.length_m * vary[1],
                up_m,
                turn_rad,
                gait.lift_m,
                gait.pitch_rad,
            )
        )
        pieces.append(Motion(gait.stance_s * vary[2], rock_rad=gait.rock_rad))
    return pieces


def turning(angle_rad: float, count: int = 3) -> list[Motion]:
    """Short strides that turn by this angle in all."""
    gait = replace(WALKING, length_m=0.35, pitch_rad=0.5)
    return strides(count, gait, turn_rad=angle_rad / count)


def square(side_m: float, gait: Gait = WALKING, *, rounds: int = 1) -> list[Motion]:
    """Sides that are whole strides, right angles in between."""
    count = max(1, round(side_m / gait.length_m))
    fitting = replace(gait, length_m=side_m / count)
    pieces = stand(3.0)
    for _ in range(4 * rounds):
        pieces += strides(count, fitting) + turning(np.pi / 2)
    return pieces + stand(2.0)


def circle(radius_m: float, gait: Gait = WALKING, *, rounds: int = 1) -> list[Motion]:
    """Chords of a circle."""
    count = max(3, round(2 * np.pi * radius_m / gait.length_m))
    chord = replace(gait, length_m=2 * radius_m * np.sin(np.pi / count))
    return [*stand(3.0), *strides(count * rounds, chord, turn_rad=2 * np.pi / count), *stand(2.0)]


def staircase(steps: int, *, rise_m: float = 0.17) -> list[Motion]:
    """One flight, up with a positive rise: a foot takes two steps in each stride."""
    return strides(steps // 2, STAIRS, up_m=2 * rise_m)


def corridor(length_m: float = 26.0, *, steps: int = 16) -> list[Motion]:
    """The article's: a straight corridor, 26 m in plan, with a flight of stairs half way."""
    flight = staircase(steps)
    level_m = length_m - STAIRS.length_m * (steps // 2)
    count = 2 * round(level_m / WALKING.length_m / 2)
    gait = replace(WALKING, length_m=level_m / count)
    half = strides(count // 2, gait)
    return [*stand(4.0), *half, *flight, *half, *stand(3.0)]


def minutes(count: float) -> list[Motion]:
    """Rounds of a square of 20 m until that much time has gone by."""
    pieces = square(20.0)
    while sum(piece.duration_s for piece in pieces) < 60 * count:
        pieces += square(20.0)[1:]
    return pieces


ROUTES = {
    "square": lambda: square(10.0),
    "circle": lambda: circle(5.0, rounds=2),
    "corridor": corridor,
    "stairs": lambda: [*stand(3.0), *staircase(20), *stand(2.0)],
    "run": lambda: [*stand(3.0), *strides(20, RUNNING), *stand(2.0)],
    "ten_minutes": lambda: minutes(10),
}
"""By name, for the command line."""


def simulate(
    pieces: Sequence[Motion],
    *,
    seed: int,
    rate_hz: float = 200.0,
    mems: Mems | None = None,
    name: str = "simulated",
    mount_wb: np.ndarray | None = None,
) -> Walk:
    """The walk with its truth: each sample's position from the first one, heading x at the start.

    mount_wb : (4,) how the sensor sits on the foot; else at random, within half a radian.
    """
    rng = np.random.default_rng(seed)
    pieces = [piece for piece in pieces if piece.duration_s > 0]
    ends_s = np.cumsum([piece.duration_s for piece in pieces])
    count = int(ends_s[-1] * rate_hz)
    t_s = np.arange(1, count + 1) / rate_hz
    state = _motion(pieces, ends_s, t_s)
    middle = _motion(pieces, ends_s, t_s - 0.5 / rate_hz)
    mems = mems or Mems()
    foot = _matrices(middle.angles)
    mount = _mount(rng) if mount_wb is None else _matrix_of(mount_wb)
    force_w = middle.acc_m_s2 + np.array([0.0, 0.0, GRAVITY_M_S2])
    force_f = np.einsum("nji,nj->ni", foot, force_w)
    rate_f = _rates(middle.angles, middle.angle_rates)
    acc, gyro = _sensed(rng, mems, t_s, rate_hz, ends_s, pieces, force_f @ mount, rate_f @ mount)
    truth = Truth(np.arange(count), state.pos_m, from_start=True)
    return Walk(name, t_s - t_s[0], acc, gyro, truth, middle.still)


@dataclass
class _State:
    pos_m: np.ndarray  # (n, 3)
    acc_m_s2: np.ndarray
    angles: np.ndarray  # (n, 2) yaw, pitch
    angle_rates: np.ndarray
    still: np.ndarray


def _blend(u):
    """From 0 to 1, its first and second derivative; four derivatives vanish at the ends."""
    value = u**5 * (126 + u * (-420 + u * (540 + u * (-315 + 70 * u))))
    return value, 630 * (u * (1 - u)) ** 4, 2520 * (u * (1 - u)) ** 3 * (1 - 2 * u)


def _bump(u):
    """0 at the ends with three derivatives, 1 in the middle."""
    v = u * (1 - u)
    rise = 1 - 2 * u
    return 256 * v**4, 1024 * v**3 * rise, 1024 * (3 * v**2 * rise**2 - 2 * v**3)


def _heel_and_toe(u):
    """The foot's pitch in a swing: heel up to 1, then toe up to about -0.4."""
    lean = 1.32 - 2.2 * u
    value, first, second = _bump(u)
    scale = 1.6
    return (
        scale * value * lean,
        scale * (first * lean - 2.2 * value),
        scale * (second * lean - 4.4 * first),
    )


def _motion(pieces, ends_s, t_s) -> _State:
    count = len(t_s)
    index = np.minimum(np.searchsorted(ends_s, t_s), len(pieces) - 1)
    begins_s = np.concatenate([[0.0], ends_s[:-1]])
    pos, acc = np.zeros((count, 3)), np.zeros((count, 3))
    angles, rates = np.zeros((count, 2)), np.zeros((count, 2))
    still = np.zeros(count, bool)
    start, yaw = np.zeros(3), 0.0
    edges = np.searchsorted(index, np.arange(len(pieces) + 1))
    for at, piece in enumerate(pieces):
        span = slice(edges[at], edges[at + 1])
        long_s = piece.duration_s
        u = np.clip((t_s[span] - begins_s[at]) / long_s, 0, 1)
        heading = yaw + piece.turn_rad / 2
        along = np.array([np.cos(heading), np.sin(heading), 0.0])
        way = piece.ahead_m * along + [0.0, 0.0, piece.up_m]
        go, lift, roll = _blend(u), _bump(u), _heel_and_toe(u)
        rock = tuple(piece.rock_rad * each for each in _bump(u))
        up = np.array([0.0, 0.0, 1.0])
        pos[span] = start + np.outer(go[0], way) + np.outer(piece.lift_m * lift[0], up)
        pos[span] += np.outer(SOLE_M * rock[0], along)
        acc[span] = np.outer(go[2], way) + np.outer(piece.lift_m * lift[2], up)
        acc[span] += np.outer(SOLE_M * rock[2], along)
        acc[span] /= long_s**2
        pitch = [piece.pitch_rad * roll[i] + rock[i] for i in (0, 1)]
        angles[span] = np.column_stack([yaw + piece.turn_rad * go[0], pitch[0]])
        rates[span] = np.column_stack([piece.turn_rad * go[1], pitch[1]]) / long_s
        still[span] = piece.ahead_m == piece.up_m == piece.turn_rad == 0
        start, yaw = start + way, yaw + piece.turn_rad
    return _State(pos, acc, angles, rates, still)


def _matrices(angles) -> np.ndarray:
    """(n, 3, 3) foot to world: yaw about z, then pitch about y."""
    (cy, sy), (cp, sp) = ((np.cos(a), np.sin(a)) for a in angles.T)
    zero = np.zeros_like(cy)
    rows = [[cy * cp, -sy, cy * sp], [sy * cp, cy, sy * sp], [-sp, zero, cp]]
    return np.moveaxis(np.array(rows), -1, 0)


def _rates(angles, rates) -> np.ndarray:
    """(n, 3) in foot axes."""
    pitch, (yaw_rate, pitch_rate) = angles[:, 1], rates.T
    return np.column_stack([-yaw_rate * np.sin(pitch), pitch_rate, yaw_rate * np.cos(pitch)])


def _matrix_of(quat) -> np.ndarray:
    w, x, y, z = np.asarray(quat, float) / np.linalg.norm(quat)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _mount(rng) -> np.ndarray:
    """Foot axes by the sensor's: the instep slopes."""
    return _matrix_of(upright(np.array([*rng.uniform(-0.4, 0.4, 2), 1.0])))


def _sensed(rng, mems: Mems, t_s, rate_hz, ends_s, pieces, force, rate):
    count = len(t_s)
    louder = np.sqrt(rate_hz / 200.0)
    walk = np.cumsum(rng.standard_normal((count, 3)), axis=0) / np.sqrt(rate_hz)
    acc = force * (1 + mems.acc_scale * rng.standard_normal(3))
    acc = acc + mems.acc_bias_m_s2 * rng.standard_normal(3)
    acc = acc + mems.acc_noise_m_s2 * louder * rng.standard_normal((count, 3))
    acc = acc + mems.impact_m_s2 * _impacts(rng, t_s, ends_s, pieces)
    gyro = rate * (1 + mems.gyro_scale * rng.standard_normal(3))
    gyro = gyro + mems.gyro_bias_rad_s * rng.standard_normal(3) + mems.gyro_walk_rad_s * walk
    gyro = gyro + mems.gyro_noise_rad_s * louder * rng.standard_normal((count, 3))
    acc = np.clip(acc, -mems.acc_range_m_s2, mems.acc_range_m_s2)
    return acc, np.clip(gyro, -mems.gyro_range_rad_s, mems.gyro_range_rad_s)


def _impacts(rng, t_s, ends_s, pieces) -> np.ndarray:
    shocks = np.zeros((len(t_s), 3))
    for end_s, piece in zip(ends_s, pieces, strict=True):
        if not piece.ahead_m:
            continue
        begin, end = np.searchsorted(t_s, [end_s, end_s + 0.06])
        since_s = t_s[begin:end] - end_s
        ringing = np.exp(-since_s / 0.015) * np.sin(2 * np.pi * 55 * since_s)
        shocks[begin:end] += np.outer(ringing, rng.standard_normal(3))
    return shocks
