# SPDX-License-Identifier: MIT
"""Is this a foot in SI units? Wrong units and rates are told by name; later ones only spoil paths.

What is taken for granted: gravity is in the acceleration, and a foot that walks turns at several
rad/s, but by less than the widest gyroscopes can tell (2000 deg/s = 35 rad/s).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from terazi.applications.walks.record import Walk
from terazi.applications.walks.swings import swing_note
from terazi.errors import CannotRead

GAP_S = 0.1
RATES_HZ = (40.0, 4000.0)
SHORTEST_S = 2.0
GRAVITY_M_S2 = (8.8, 10.8)  # of 9.81, with scale errors of 10 %
RATE_MAX_RAD_S = 45.0
RATE_MIN_RAD_S = 0.7  # a foot that walks turns faster in every step
SHAKEN_M_S2 = 1.0  # rms of the acceleration's size: walking; at rest it is some 0.05
LONGEST_MOTION_S = 8.0
LEAST_STILL = 0.01  # share of the record
STRIDE_S = (0.5, 4.0)  # of a runner, of a very slow walker

ACC_GUESSES = {
    "g": 1 / 9.80665,
    "mg": 1000 / 9.80665,
    "cm/s^2 (gal)": 100.0,
    "m/s^2, converted from g once more": 9.80665,
    "m/s^2, given as g": 9.80665,
    "half of it: the sensor's range is set otherwise": 0.5,
    "twice it: the sensor's range is set otherwise": 2.0,
}


def check(walk: Walk) -> Walk:
    """The walk as it is; CannotRead says what cannot be true."""
    if not (np.isfinite(walk.acc_b_m_s2).all() and np.isfinite(walk.gyro_b_rad_s).all()):
        raise CannotRead(f"{walk.name}: samples hold what is no number")
    _check_rate(walk)
    if not np.ptp(np.hstack([walk.acc_b_m_s2, walk.gyro_b_rad_s]), axis=0).any():
        raise CannotRead(f"{walk.name}: every sample is the same: is the sensor read at all?")
    _check_acceleration(walk)
    _check_turning(walk)
    return replace(walk, notes=(*walk.notes, *_gap_note(walk)))


def _gap_note(walk: Walk) -> tuple[str, ...]:
    steps_s = np.diff(walk.t_s)
    gaps = np.flatnonzero(steps_s > GAP_S)
    if not len(gaps):
        return ()
    longest = gaps[np.argmax(steps_s[gaps])]
    return (
        f"gaps of the times: {len(gaps)}, the longest {steps_s[longest]:.2f} s at "
        f"{walk.t_s[longest]:.1f} s: where the foot went meanwhile is not known",
    )


def sane_rate(walk: Walk) -> bool:
    """The rate is one of a sensor for walks."""
    return RATES_HZ[0] <= walk.rate_hz <= RATES_HZ[1]


def _check_rate(walk: Walk) -> None:
    usual_hz = walk.rate_hz
    if not sane_rate(walk):
        raise CannotRead(
            f"{walk.name}: {usual_hz:.6g} samples a second; {RATES_HZ[0]:g} to {RATES_HZ[1]:g} do",
            remedy="Are the times in ms or us? An .npz gives s; a CSV's layout says which.",
        )
    if len(walk) / usual_hz < SHORTEST_S:
        raise CannotRead(f"{walk.name}: {len(walk)} samples are less than {SHORTEST_S:g} s")


def _check_acceleration(walk: Walk) -> None:
    turning = np.linalg.norm(walk.gyro_b_rad_s, axis=1)
    quiet = turning <= np.quantile(turning, 0.25)
    found = float(np.median(np.linalg.norm(walk.acc_b_m_s2[quiet], axis=1)))
    if GRAVITY_M_S2[0] <= found <= GRAVITY_M_S2[1]:
        return
    likely = [name for name, scale in ACC_GUESSES.items() if 0.9 < found / (9.81 * scale) < 1.1]
    if found < 0.3 * 9.81 and not likely:
        likely = ["acceleration without gravity, which a walk cannot be made of"]
    raise CannotRead(
        f"{walk.name}: at its quietest the acceleration is {found:.3g} m/s^2, not 9.81",
        remedy=f"It looks like {' or '.join(likely)}."
        if likely
        else "Wrong unit or scale, gravity taken off, or a sensor that never stands still.",
    )


def _check_turning(walk: Walk) -> None:
    turning = np.linalg.norm(walk.gyro_b_rad_s, axis=1)
    fastest = float(np.quantile(turning, 0.999))
    if fastest > RATE_MAX_RAD_S:
        raise CannotRead(
            f"{walk.name}: it turns at {fastest:.3g} rad/s, which no foot does",
            remedy="It looks like deg/s that were given as rad/s.",
        )
    shaken = float(np.std(np.linalg.norm(walk.acc_b_m_s2, axis=1)))
    if shaken > SHAKEN_M_S2 and fastest < RATE_MIN_RAD_S:
        raise CannotRead(
            f"{walk.name}: its acceleration walks, but it turns at {fastest:.3g} rad/s at most",
            remedy="It looks like rad/s that were given as deg/s.",
        )


def check_standing(walk: Walk, still: np.ndarray) -> Walk:
    """The walk with notes on where it stands; CannotRead where it never does.

    still : (n,) bool, zero velocity.
    """
    if np.mean(still) < LEAST_STILL:
        raise CannotRead(
            f"{walk.name}: the sensor never stands still "
            f"(by the detector: {100 * np.mean(still):.2g} % of the time)",
            remedy="It must be fixed to the foot, not to hip or hand. Else try --detector.",
        )
    stands = np.flatnonzero(still)
    edges = np.concatenate([[0], stands, [len(walk) - 1]])
    gap = int(np.argmax(np.diff(walk.t_s[edges])))
    begin_s, end_s = walk.t_s[edges[gap]], walk.t_s[edges[gap + 1]]
    notes = list(walk.notes)
    if end_s - begin_s > LONGEST_MOTION_S:
        notes.append(
            f"no standstill from {begin_s:.1f} s to {end_s:.1f} s: the path drifts there freely"
        )
    return replace(walk, notes=(*notes, *swing_note(walk, still)))


def stride_note(durations_s: np.ndarray) -> tuple[str, ...]:
    """A doubt about the rate, where strides last longer or shorter than a walker's."""
    if len(durations_s) < 5:
        return ()
    usual_s = float(np.median(durations_s))
    if STRIDE_S[0] <= usual_s <= STRIDE_S[1]:
        return ()
    return (f"strides last {usual_s:.2f} s: is the rate of the samples right?",)
