# SPDX-License-Identifier: MIT
"""mahony of shared_c for numpy and, step by step, for Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from terazi.cshared._cshared import ffi, lib
from terazi.cshared.imu import Rest, int16_vectors, pointer

MAHONY_CONFIGS = tuple(
    sorted(
        (each.removeprefix("MAHONY_CONFIG_").lower() for each in dir(lib) if "_CONFIG_" in each),
        key=lambda name: getattr(lib, f"MAHONY_CONFIG_{name.upper()}", -1),
    )
)
"""Configurations of mahony.toml."""

MODE_FIELDS = ("steps", "mode", "integral")  # beside `usual`
COUNTS = ("acc_zero", "railed", "mag_refused", "mag_disturbed", "gaps")
Q13 = 1 << 13
Q30 = 1 << 30


def _vector(values: Sequence[int]):
    return ffi.new("int16_t[3]", [int(each) for each in values])


class Mahony:
    """One attitude filter (mahony.h).

    config : name of a configuration of mahony.toml, or fields of mahony_modes_config_t, as
        terazi.design.mahony.config_at makes them for any rate and sensor.
    """

    def __init__(self, config: str | Mapping[str, int]):
        if isinstance(config, str):
            if config not in MAHONY_CONFIGS:
                known = ", ".join(MAHONY_CONFIGS)
                raise ValueError(f"no configuration {config!r}; there are {known}")
            self._config = ffi.addressof(lib, f"mahony_{config}")
        else:
            usual = dict(config)
            modes = {name: usual.pop(name) for name in MODE_FIELDS if name in usual}
            try:
                self._config = ffi.new("mahony_modes_config_t *", {"usual": usual, **modes})
            except OverflowError as error:
                raise ValueError(f"configuration of mahony: {error}") from None
            if not lib.mahony_modes_is_lawful(self._config):
                raise ValueError(f"configuration of mahony is beyond mahony.h: {dict(config)}")
        self._modes = ffi.new("mahony_modes_t *")
        self._c = ffi.addressof(self._modes, "mahony")
        lib.mahony_modes_init(self._modes, self._config)
        self._euler = ffi.new("mahony_euler_t *")

    def update(
        self,
        gyro_b_counts: Sequence[int],
        acc_b_counts: Sequence[int],
        bias_q16: Sequence[int] = (0, 0, 0),
    ) -> None:
        """One sample of gyroscope and accelerometer, and the gyroscope's bias."""
        bias = ffi.new("int32_t[3]", [int(each) for each in bias_q16])
        lib.mahony_modes_update(self._modes, _vector(gyro_b_counts), _vector(acc_b_counts), bias)

    def update_mag(self, mag_b_counts: Sequence[int]) -> None:
        """One sample of the magnetometer."""
        lib.mahony_update_mag(self._c, _vector(mag_b_counts))

    def gap(self, samples: int) -> None:
        """So many samples are missing before the next one."""
        lib.mahony_modes_gap(self._modes, samples)

    @property
    def quat_wb_q30(self) -> tuple[int, int, int, int]:
        """The attitude, scalar first, body to world, norm 1 within 1e-6."""
        quat = ffi.new("int32_t[4]")
        lib.mahony_quaternion(self._c, quat)
        return tuple(quat)

    @property
    def state_q30(self) -> tuple[int, int, int, int]:
        """The same as the filter holds it and ATTITUDE tells it: norm 1 within 3e-4."""
        return tuple(self._c.step.quat_wb_q30)

    @property
    def quat_wb(self) -> np.ndarray:
        """The attitude as (4,) float64."""
        return np.array(self.quat_wb_q30) / Q30

    @property
    def euler_q13(self) -> tuple[int, int, int]:
        """Roll, pitch and yaw in rad Q13, order z-y-x."""
        lib.mahony_euler(self._c, self._euler)
        return self._euler.roll_q13, self._euler.pitch_q13, self._euler.yaw_q13

    @property
    def up_b_q14(self) -> tuple[int, int, int]:
        """The vertical in body axes."""
        up = ffi.new("int16_t[3]")
        lib.mahony_up(self._c, up)
        return tuple(up)

    def free_acceleration(self, acc_b_counts: Sequence[int]) -> tuple[int, int, int]:
        """acc less gravity, in body axes."""
        free = ffi.new("int16_t[3]")
        lib.mahony_free_acceleration(self._c, _vector(acc_b_counts), free)
        return tuple(free)

    @property
    def counts(self) -> dict[str, int]:
        """What was skipped, bridged or at a rail so far; each stops at 65535."""
        return {name: getattr(self._c.counts, name) for name in COUNTS}

    def block(
        self,
        gyro_b_counts,
        acc_b_counts,
        mag_b_counts=None,
        *,
        bias_q16=None,
        rest=None,
        as_state=False,
    ) -> np.ndarray:
        """Take (n, 3) samples; gives (n, 4) int32 attitudes in Q30 after each.

        mag_b_counts : (n, 3), for 9 axes.
        bias_q16 : (3,) or (n, 3) int32;  rest : or a Rest that learns it on the way.
        as_state : as state_q30, without a Rest.
        """
        vectors = [int16_vectors(gyro_b_counts, "gyroscope values")]
        vectors.append(int16_vectors(acc_b_counts, "accelerometer values"))
        if mag_b_counts is not None:
            vectors.append(int16_vectors(mag_b_counts, "magnetometer values"))
        if len({len(each) for each in vectors}) != 1:
            raise ValueError(f"unequal numbers of samples: {[len(each) for each in vectors]}")
        gyro, acc, *more = vectors
        count = len(gyro)
        mag = pointer(more[0]) if more else ffi.NULL
        quats = np.empty((count, 4), dtype=np.int32)
        if rest is not None:
            if bias_q16 is not None or as_state:
                raise ValueError("either rest or bias_q16 gives the bias, and no state with rest")
            lib.mahony_blocks_run_rest(
                self._modes, rest.c_state, pointer(gyro), pointer(acc), mag, pointer(quats), count
            )
            return quats
        bias, step = _bias(bias_q16, count)
        lib.mahony_blocks_run(
            self._modes,
            *(pointer(gyro), pointer(acc), mag),
            *(ffi.NULL if bias is None else pointer(bias), step, as_state),
            *(pointer(quats), count),
        )
        return quats

    def save(self) -> bytes:
        """State, for restore() on one of the same configuration, in the same process."""
        return bytes(ffi.buffer(self._modes)) + bytes(ffi.buffer(self._euler))

    def restore(self, state: bytes) -> None:
        """Continue where save() was called."""
        own = ffi.sizeof(self._modes[0])
        if len(state) != own + ffi.sizeof(self._euler[0]):
            raise ValueError("not the state of a Mahony")
        ffi.buffer(self._modes)[:] = state[:own]
        ffi.buffer(self._euler)[:] = state[own:]
        self._modes.config = self._config
        self._c.config = ffi.addressof(self._config, "usual")

    def copy(self) -> Mahony:
        """Another one in the same state."""
        twin = object.__new__(Mahony)
        twin._config = self._config  # constant: shared
        twin._modes = ffi.new("mahony_modes_t *", self._modes[0])
        twin._c = ffi.addressof(twin._modes, "mahony")
        twin._euler = ffi.new("mahony_euler_t *", self._euler[0])
        return twin


def _bias(bias_q16, count: int) -> tuple[np.ndarray | None, int]:
    if bias_q16 is None:
        return None, 0
    bias = np.ascontiguousarray(bias_q16, dtype=np.int32)
    if not np.array_equal(bias, np.asarray(bias_q16)):
        raise ValueError("bias_q16 must be integers of 32 bits")
    if bias.shape not in ((3,), (count, 3)):
        raise ValueError(f"bias_q16 must have the shape (3,) or ({count}, 3), not {bias.shape}")
    return bias, 0 if bias.ndim == 1 else 3


def mahony_block(
    gyro_b_counts,
    acc_b_counts,
    mag_b_counts=None,
    *,
    config: str | Mapping[str, int] = "286hz",
    rest_config: str | Mapping[str, int] | None = None,
    bias_q16=None,
) -> np.ndarray:
    """Attitudes, (n, 4) int32 in Q30, of (n, 3) samples; the gyroscope's bias as Mahony.block or,
    with rest_config, learnt at rest."""
    rest = None if rest_config is None else Rest(rest_config)
    return Mahony(config).block(
        gyro_b_counts, acc_b_counts, mag_b_counts, bias_q16=bias_q16, rest=rest
    )
