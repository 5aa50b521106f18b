# SPDX-License-Identifier: MIT
"""Trials in BROAD's manner, made up: a board that lies, is turned about, lies again."""

import numpy as np

GRAVITY_M_S2 = 9.80665
FIELD_UT = np.array([0.0, 19.0, -46.0])  # magnetic north is y; it dips by 68 degrees
RATE_HZ = 2000 / 7


def multiply(a, b):
    """Quaternions, scalar first."""
    w = a[0] * b[0] - np.dot(a[1:], b[1:])
    return np.concatenate([[w], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])])


def to_body(quats, vector_w):
    """(n, 3): a world vector in the axes of the body."""
    w, v = quats[:, :1], -quats[:, 1:]
    world = np.broadcast_to(vector_w, v.shape)
    cross = np.cross(v, world)
    return world + 2 * (w * cross + np.cross(v, cross))


def orientations(rate_hz, *, rest_s, move_s, seed):
    """(n, 4) quaternions body to world, (n, 3) turn rates in the body, (n,) movement."""
    rng = np.random.default_rng(seed)
    rest, move = round(rest_s * rate_hz), round(move_s * rate_hz)
    t = np.arange(move) / rate_hz
    # Begins and ends at once, as a hand does: creeping on from rest would be taken for a bias.
    swing = np.minimum(1, np.minimum(t, move_s - t) / 0.1)[:, None]
    turns = sum(
        swing * np.outer(np.cos(2 * np.pi * f * t), rng.uniform(-0.7, 0.7, 3))
        for f in (0.3, 0.7, 1.1)
    )
    rates = np.vstack([np.zeros((rest, 3)), turns, np.zeros((rest, 3))])
    quats = np.empty((len(rates), 4))
    quat = rng.normal(size=4) * (1, 0.2, 0.2, 1)
    quat /= np.linalg.norm(quat)
    for n, rate in enumerate(rates):  # the rate holds for the step that ends at this sample
        angle = np.linalg.norm(rate) / rate_hz
        axis = rate / max(np.linalg.norm(rate), 1e-12)
        step = np.concatenate([[np.cos(angle / 2)], axis * np.sin(angle / 2)])
        quat = multiply(quat, step)
        quats[n] = quat
    moving = np.concatenate([np.zeros(rest), np.ones(move), np.zeros(rest)])
    return quats, rates, moving


def fields(*, rate_hz=RATE_HZ, rest_s=4.0, move_s=20.0, bias_deg_s=(0.4, -0.3, 0.6), seed=1):
    """What np.savez is given for a whole trial."""
    rng = np.random.default_rng(seed)
    quats, rates, moving = orientations(rate_hz, rest_s=rest_s, move_s=move_s, seed=seed)
    gyro = np.degrees(rates) + bias_deg_s + rng.normal(0, 0.08, rates.shape)
    up_g = to_body(quats, (0, 0, 1.0)) + rng.normal(0, 0.003, rates.shape)
    field = to_body(quats, FIELD_UT) + rng.normal(0, 0.3, rates.shape)

    def counts(values, scale):
        return np.rint(values * scale).astype(np.int16)

    return {
        "gyr": counts(gyro, 16.384),
        "acc": counts(up_g, 2048),
        "mag": counts(field, 100),
        "quat": counts(quats, 32767),
        "movement": moving.astype(np.uint8),
        "sampling_rate": rate_hz,
        "gyr_lsb_per_dps": 16.384,
        "acc_lsb_per_g": 2048.0,
        "acc_g": GRAVITY_M_S2,
        "mag_lsb_per_uT": 100.0,
    }


def write(path, changed=None, without=(), **how):
    """Write a trial; `changed` replaces fields, `without` leaves them out."""
    content = {**fields(**how), **(changed or {})}
    np.savez(path, **{name: each for name, each in content.items() if name not in without})
    return path
