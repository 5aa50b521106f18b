# SPDX-License-Identifier: MIT
"""The filter in C against a plain one of matrices: propagation, updates, smoother."""

import numpy as np
import pytest

from terazi.cshared import Ins

GRAVITY = 9.81
SIGMAS = {"velocity": 0.1, "attitude": 0.05, "gyro_bias": 0.02, "acc_bias": 0.2}
NOISES = {"velocity": 0.05, "attitude": 0.01, "gyro_bias": 1e-3, "acc_bias": 1e-2}
MORE = {"gyro_scale": 0.01, "acc_scale": 0.02, "gravity": 0.05}


def record(count=120, seed=1):
    rng = np.random.default_rng(seed)
    dt_s = np.full(count, 0.01)
    acc = rng.normal([0.3, -0.2, GRAVITY], 1.0, (count, 3))
    gyro = rng.normal(0, 0.5, (count, 3))
    vel = np.where(rng.random(count) < 0.3, 0.05, 0.0)
    rate = np.where(rng.random(count) < 0.2, 0.1, 0.0)
    level = np.zeros(count)
    level[::25] = 0.02
    return dt_s, acc, gyro, vel, rate, level


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def turn(vector):
    """Matrix of a rotation vector, by Rodrigues."""
    angle = np.linalg.norm(vector)
    k = skew(vector)
    if angle < 1e-12:
        return np.eye(3) + k
    return np.eye(3) + np.sin(angle) / angle * k + (1 - np.cos(angle)) / angle**2 * k @ k


class Plain:
    """The same filter with whole matrices, textbook fashion; keeps what a smoother needs."""

    def __init__(self, states):
        n = self.n = states
        self.pos, self.vel, self.rot = np.zeros(3), np.zeros(3), np.eye(3)
        self.rest = np.zeros(n - 9)  # biases, scales, gravity's error
        sigmas = {**SIGMAS, **(MORE if n == 24 else {})}
        order = ["position", "velocity", "attitude", "gyro_bias", "acc_bias", *MORE]
        self.cov = np.diag(np.repeat([sigmas.get(name, 0.0) ** 2 for name in order], 3)[:n])
        noise = np.repeat([NOISES.get(name, 0.0) ** 2 for name in order], 3)[:n]
        self.noise = np.diag(noise)
        self.floor = None
        self.history = []

    def step(self, dt, acc, gyro, vel, rate, level):
        n, more = self.n, self.n == 24
        scale_w = self.rest[6:9] if more else np.zeros(3)
        scale_a = self.rest[9:12] if more else np.zeros(3)
        gravity = [0, 0, -GRAVITY] + (self.rest[12:15] if more else np.zeros(3))
        rate_b = gyro * (1 - scale_w) - self.rest[:3]
        half = self.rot @ turn(rate_b * dt / 2)
        self.rot = half @ turn(rate_b * dt / 2)
        force = half @ (acc * (1 - scale_a) - self.rest[3:6])
        motion = force + gravity
        self.pos = self.pos + dt * (self.vel + dt / 2 * motion)
        self.vel = self.vel + dt * motion
        phi = np.eye(n)
        phi[0:3, 3:6] = dt * np.eye(3)
        phi[3:6, 6:9] = -dt * skew(force)
        phi[3:6, 12:15] = phi[6:9, 9:12] = -dt * half
        if more:
            phi[6:9, 15:18] = -dt * half * gyro
            phi[3:6, 18:21] = -dt * half * acc
            phi[3:6, 21:24] = dt * np.eye(3)
        before = self.cov
        self.cov = phi @ self.cov @ phi.T + self.noise * dt
        predicted = self.cov
        h, z, r = [], [], []
        for axis in range(3):
            if vel:
                h.append(np.eye(n)[3 + axis])
                z.append(-self.vel[axis])
                r.append(vel**2)
        for axis in range(3):
            if rate:
                h.append(np.eye(n)[9 + axis])
                z.append((gyro * (1 - scale_w) - self.rest[:3])[axis])
                r.append(rate**2)
        if level:
            if self.floor is None:
                self.floor = self.pos[2]
            else:
                h.append(np.eye(n)[2])
                z.append(self.floor - self.pos[2])
                r.append(level**2)
        error = np.zeros(n)
        if h:
            h, z, r = np.array(h), np.array(z), np.diag(r)
            gain = self.cov @ h.T @ np.linalg.inv(h @ self.cov @ h.T + r)
            error = gain @ z
            left = np.eye(n) - gain @ h
            self.cov = left @ self.cov @ left.T + gain @ r @ gain.T
        self.pos = self.pos + error[:3]
        self.vel = self.vel + error[3:6]
        self.rot = turn(error[6:9]) @ self.rot
        self.rest = self.rest + error[9:]
        self.history.append((phi, before, predicted, self.cov, error))
        return np.concatenate([self.pos, self.vel])


def compared(states, samples):
    plain = Plain(states)
    expected = np.array([plain.step(*row) for row in zip(*samples, strict=True)])
    sigmas = {**SIGMAS, **(MORE if states == 24 else {})}
    ins = Ins((1, 0, 0, 0), sigmas=sigmas, noises=NOISES, gravity_m_s2=GRAVITY, level_gate_m=1e9)
    return ins, plain, expected


@pytest.mark.parametrize("states", [15, 24])
def test_ins_agrees_with_a_plain_filter_of_matrices(states):
    samples = record()
    ins, plain, expected = compared(states, samples)
    path, bias = ins.run(*samples)
    assert np.allclose(path[:, :6], expected, rtol=0, atol=1e-9)
    assert np.allclose(bias[-1], plain.rest[:6], atol=1e-9)
    assert np.allclose(ins.covariance, plain.cov, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("states", [15, 24])
def test_ins_smoother_agrees_with_rauch_tung_and_striebel(states):
    """Errors about the filter's own path: x_s = A (x_s' - x_p'), x_p' taken up by the updates."""
    samples = record(60)
    ins, plain, filtered = compared(states, samples)
    expected = filtered.copy()
    following = np.zeros(states)  # smoothed error after the update, about the filtered state
    for at in range(len(filtered) - 1, 0, -1):
        phi, before, predicted, _cov, error = plain.history[at]
        back = before @ phi.T @ np.linalg.pinv(predicted, rcond=1e-13, hermitian=True)
        following = back @ (error + following)
        expected[at - 1] = filtered[at - 1] + following[:6]
    path, _ = ins.run(*samples, smooth_len=60)
    assert np.allclose(path[:, :6], expected, atol=2e-5)
    assert np.abs(expected - filtered).max() > 1e-3


def test_ins_covariance_stays_symmetric_and_positive():
    ins, _, _ = compared(24, record(3000, seed=3))
    ins.run(*record(3000, seed=3))
    cov = ins.covariance
    assert np.allclose(cov, cov.T, atol=1e-10)
    assert np.linalg.eigvalsh((cov + cov.T) / 2).min() > -1e-12


def test_ins_in_pieces_is_the_same_as_at_once():
    samples = record(700)
    whole, _ = compared(15, samples)[0].run(*samples)
    ins = compared(15, samples)[0]
    parts = [ins.run(*(each[span] for each in samples))[0] for span in
             (slice(0, 13), slice(13, 520), slice(520, 700))]  # fmt: skip
    assert np.array_equal(np.vstack(parts), whole)


def test_ins_gate_makes_an_outlier_pull_less_and_counts_it():
    samples = list(record(40, seed=2))
    samples[3] = np.zeros(40)
    samples[3][30] = 0.001
    samples[4] = samples[5] = np.zeros(40)
    loose, tight = (
        Ins((1, 0, 0, 0), sigmas={"velocity": 1e-3}, noises={"velocity": 1e-3},
            gravity_m_s2=GRAVITY, gate_sigmas=gate)
        for gate in (0.0, 3.0)
    )  # fmt: skip
    jumps = [np.linalg.norm(np.diff(ins.run(*samples)[0][29:31, 3:6], axis=0)) for ins in
             (loose, tight)]  # fmt: skip
    assert jumps[1] < 0.5 * jumps[0]
    assert (loose.clipped, tight.clipped > 0) == (0, True)


@pytest.mark.parametrize("spoilt", range(6))
def test_ins_refuses_what_is_no_number(spoilt):
    samples = [np.array(each) for each in record(20)]
    samples[spoilt].flat[3] = np.nan
    ins, _, _ = compared(15, record(20))
    with pytest.raises(ValueError, match="finite"):
        ins.run(*samples)


def test_ins_refuses_names_and_lengths_that_do_not_fit():
    with pytest.raises(ValueError, match="no states 'heading'"):
        Ins((1, 0, 0, 0), sigmas={"heading": 1.0}, noises={}, gravity_m_s2=GRAVITY)
    samples = list(record(20))
    samples[0] = samples[0][:-1]
    with pytest.raises(ValueError, match="unequal"):
        compared(15, record(20))[0].run(*samples)
