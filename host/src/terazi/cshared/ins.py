# SPDX-License-Identifier: MIT
"""ins_blocks for numpy: an inertial navigator with an error-state Kalman filter."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from terazi.cshared._cshared import ffi, lib

BLOCKS = (
    *("position", "velocity", "attitude", "gyro_bias", "acc_bias"),
    *("gyro_scale", "acc_scale", "gravity"),
)
"""Blocks of three states each; the last three only where there are 24 states."""
PATH_COLUMNS, BIAS_COLUMNS = 10, 6
PIECE = 512  # samples in one call: between them, progress is told and a smoother's tape ends


class Ins:
    """The filter's state (ins_blocks.h).

    quat_wb : (4,) attitude at the start.
    sigmas, noises : by block's name, 1 sigma at the start and 1 sigma gained in a second; what is
        left out is 0. A block of the last three with either makes it 24 states.
    gravity_m_s2 : along the vertical.  gate_sigmas : 0 for none.
    level_gate_m : a foot that stands farther from the last floor's height stands on another one.
    """

    def __init__(
        self,
        quat_wb,
        *,
        sigmas: dict[str, float | tuple[float, float, float]],
        noises: dict[str, float],
        gravity_m_s2: float,
        gate_sigmas: float = 0.0,
        level_gate_m: float = 0.0,
    ) -> None:
        for name in (*sigmas, *noises):
            if name not in BLOCKS:
                raise ValueError(f"no states {name!r}; there are {', '.join(BLOCKS)}")
        more = any(np.any(each.get(name, 0.0)) for each in (sigmas, noises) for name in BLOCKS[5:])
        states = 24 if more else 15
        self._c = ffi.new("ins_t *")
        self._c.states = states
        self._c.gate_sigmas = gate_sigmas
        self._c.quat_wb = [float(each) for each in quat_wb]
        self._c.level_gate_m = level_gate_m
        self._c.gravity_w_m_s2 = [0.0, 0.0, -gravity_m_s2]
        for at, name in enumerate(BLOCKS):
            self._c.noise_per_s[at] = noises.get(name, 0.0) ** 2
            if 3 * at < states:
                for axis, sigma in enumerate(np.broadcast_to(sigmas.get(name, 0.0), 3)):
                    self._c.cov[(3 * at + axis) * (states + 1)] = float(sigma) ** 2

    @property
    def clipped(self) -> int:
        """Updates that the gate made smaller, so far."""
        return self._c.clipped

    @property
    def covariance(self) -> np.ndarray:
        """(states, states), of the errors."""
        states = self._c.states
        return np.frombuffer(ffi.buffer(self._c.cov), count=states**2).reshape(states, -1).copy()

    def run(
        self,
        dt_s,
        acc_b_m_s2,
        gyro_b_rad_s,
        vel_sigma_m_s,
        rate_sigma_rad_s,
        level_sigma_m,
        *,
        smooth_len: int = 0,
        progress: Callable[[float], None] | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Take n samples; gives the (n, 10) path (position, velocity, quat_wb) and (n, 6) biases.

        dt_s : (n,) s since the sample before;  acc, gyro : (n, 3);  sigmas : (n,), of zero
            velocity, zero angular rate and unchanged height at each sample, 0 for none.
        smooth_len : samples of the future that the path may know, at least; at most twice as many
            are used. 0: none. The biases are always those of the filter.
        """
        columns = [_floats(dt_s, 1), _floats(acc_b_m_s2, 2), _floats(gyro_b_rad_s, 2)]
        columns += [_floats(vel_sigma_m_s, 1), _floats(rate_sigma_rad_s, 1)]
        columns.append(_floats(level_sigma_m, 1))
        count = len(columns[0])
        if {len(each) for each in columns} != {count}:
            raise ValueError(f"unequal numbers of samples: {[len(each) for each in columns]}")
        path, bias = np.empty((count, PATH_COLUMNS)), np.empty((count, BIAS_COLUMNS))
        piece = smooth_len or PIECE
        tape = ffi.new("ins_tape_t[]", 2 * piece) if smooth_len else ffi.NULL
        for begin in range(0, count, piece):
            end = min(begin + piece, count)
            held = piece if smooth_len and begin else 0
            lib.ins_blocks_run(
                self._c,
                *(_pointer(each[begin:end]) for each in columns),
                *(_pointer(path[begin:end]), _pointer(bias[begin:end])),
                *(tape + held if smooth_len else ffi.NULL, end - begin),
            )
            if smooth_len and (begin or end == count):
                first = begin - held
                kept = end - first if end == count else piece
                lib.ins_blocks_smooth(
                    tape, end - first, kept, self._c.states, _pointer(path[first:end])
                )
                size = piece * ffi.sizeof("ins_tape_t")
                ffi.memmove(tape, tape + piece, size)
            if progress:
                progress(end / count)
        return path, bias

    def run_at_once(
        self,
        dt_s,
        acc_b_m_s2,
        at_once,
        revised,
        *,
        revised_after: int,
        piece: int,
        progress: Callable[[float], None] | None = None,
    ) -> np.ndarray:
        """Take n samples; gives the (n, 10) path as each sample is known at that sample.

        at_once, revised : (n, 3) angular rates and three (n,) sigmas each, as run() takes them:
            those that are known at a sample, and those that are known `revised_after` later.

        A sigma of velocity that comes or goes by being revised is a reason to go back and run again
        from there, at the end of the next `piece` of samples; what else changes can wait until
        `revised_after` samples have gathered. What was told before then stays told: row i
        depends on samples 0 .. i alone. The state is afterwards that of the revised sigmas, where
        they are known.
        """
        base = [_floats(dt_s, 1), _floats(acc_b_m_s2, 2)]
        first, final = (
            [*base, _floats(rates, 2), *(_floats(each, 1) for each in sigmas)]
            for rates, *sigmas in (at_once, revised)
        )
        count = len(base[0])
        if {len(each) for each in (*first, *final)} != {count}:
            raise ValueError("unequal numbers of samples")
        flips = _so_far((first[3] > 0) != (final[3] > 0))
        changes = _so_far(np.any(np.column_stack(first[2:]) != np.column_stack(final[2:]), axis=1))
        path = np.empty((count, PATH_COLUMNS))
        again = np.empty((revised_after + piece, PATH_COLUMNS))
        ahead, known = ffi.new("ins_t *", self._c[0]), 0
        for begin in range(0, count, piece):
            end, final_end = min(begin + piece, count), max(0, begin - revised_after)
            waited = final_end - known >= revised_after and changes[final_end] > changes[known]
            if waited or flips[final_end] > flips[known]:
                self._step(
                    self._c, final, known, final_end, np.empty((final_end - known, PATH_COLUMNS))
                )
                known = final_end
                ffi.memmove(ahead, self._c, ffi.sizeof("ins_t"))
                self._step(ahead, first, known, begin, again)
            self._step(ahead, first, begin, end, path[begin:end])
            if progress:
                progress(end / count)
        return path

    @staticmethod
    def _step(state, columns, begin: int, end: int, path: np.ndarray) -> None:
        lib.ins_blocks_run(
            state,
            *(_pointer(each[begin:end]) for each in columns),
            *(_pointer(path), ffi.NULL, ffi.NULL, end - begin),
        )


def _so_far(which: np.ndarray) -> np.ndarray:
    """(n + 1,) how many of the first 0 .. n are true."""
    return np.concatenate([[0], np.cumsum(which)])


def _floats(values, dimensions: int) -> np.ndarray:
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.ndim != dimensions or (dimensions == 2 and array.shape[1] != 3):
        raise ValueError(f"samples of the shape {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError("samples must be finite")
    return array


def _pointer(array: np.ndarray):
    return ffi.cast("double *", ffi.from_buffer(array, require_writable=False))
