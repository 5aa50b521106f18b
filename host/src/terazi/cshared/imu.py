# SPDX-License-Identifier: MIT
"""imu_cal and rest of shared_c for numpy and, step by step, for Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from terazi.cshared._cshared import ffi, lib
from terazi.cshared.state import CState
from terazi.design import rest as rest_design

REST_RATES = tuple(
    sorted(
        (name.removeprefix("REST_RATE_").lower() for name in dir(lib) if "REST_RATE_" in name),
        key=lambda name: getattr(lib, f"REST_RATE_{name.upper()}"),
    )
)
"""Rates of rest.toml."""

SLOPE_MAX = 1 << 14  # imu_cal.h
AT_REST, BIAS_KNOWN = lib.REST_AT_REST, lib.REST_BIAS_KNOWN


def int16_vectors(values, what: str) -> np.ndarray:
    """values as a contiguous (n, 3) int16 array, refused where that would change one."""
    array = np.asarray(values)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{what} must have the shape (n, 3), not {array.shape}")
    if array.size and array.dtype.kind not in "iu":
        raise TypeError(f"{what} must be integers, not {array.dtype}")
    converted = np.ascontiguousarray(array, dtype=np.int16)
    if not np.array_equal(converted, array):
        raise ValueError(f"{what} do not fit in 16 bits")
    return converted


def pointer(array: np.ndarray):
    """A C pointer to a numpy array's values."""
    return ffi.from_buffer(f"{array.dtype.name}_t[]", array, require_writable=array.flags.writeable)


class ImuCal(CState):
    """Calibration of one sensor of three axes (imu_cal.h).

    matrix_q16 : (3, 3) M - I;  offset_q3 : (3,), after M. Without any: identity.
        terazi.models.imu_cal.config makes them from true constants.
    """

    def __init__(
        self,
        matrix_q16: Sequence[Sequence[int]] = ((0, 0, 0),) * 3,
        offset_q3: Sequence[int] = (0, 0, 0),
    ):
        fields = {
            "matrix_q16": [[int(each) for each in row] for row in matrix_q16],
            "offset_q3": [int(each) for each in offset_q3],
        }
        try:
            self._reference = ffi.new("imu_cal_config_t *", fields)
        except OverflowError as error:
            raise ValueError(f"calibration: {error}") from None
        if not lib.imu_cal_is_lawful(self._reference):
            raise ValueError("a row of matrix_q16 is beyond imu_cal.h")
        self._config = self._reference
        self._c = ffi.new("imu_cal_t *")
        lib.imu_cal_init(self._c, self._config)

    @property
    def clipped(self) -> int:
        """Vectors with a value on a rail so far, stops at 65535."""
        return self._c.clipped

    @property
    def offset_q3(self) -> tuple[int, int, int]:
        """After M, counts, at the present temperature."""
        return tuple(self._config.offset_q3)

    def set_temperature(self, above_reference_counts: int, slope_q16: Sequence[int]) -> None:
        """From now on the sensor is so much warmer than at the reference.

        slope_q16 : (3,), after M, terazi.models.imu_cal.slope_q16. Not part of what save() gives.
        """
        slope = [int(each) for each in slope_q16]
        if max(map(abs, slope)) > SLOPE_MAX:
            raise ValueError("a slope is beyond imu_cal.h")
        self._config = ffi.new("imu_cal_config_t *")
        lib.imu_cal_at_temperature(
            self._reference, ffi.new("int16_t[3]", slope), above_reference_counts, self._config
        )
        self._c.config = self._config

    def apply(self, raw_b_counts: Sequence[int]) -> tuple[int, int, int]:
        """Calibrate one vector."""
        vector = ffi.new("int16_t[3]", [int(each) for each in raw_b_counts])
        lib.imu_cal_apply(self._c, vector)
        return tuple(vector)

    def block(self, raw_b_counts) -> np.ndarray:
        """Calibrate (n, 3) vectors; gives (n, 3) int16."""
        calibrated = int16_vectors(raw_b_counts, "raw values").copy()
        lib.imu_blocks_cal(self._c, pointer(calibrated), len(calibrated))
        return calibrated


class ImuTurn:
    """From a part's axes to the board's (imu_cal_turn of imu_cal.h).

    orientation : code of imu_cal.h, as in the settings imu.orientation and mag.orientation;
        terazi.models.imu_cal.ORIENTATIONS names all of them. The usual one turns nothing.
    """

    def __init__(self, orientation: int = lib.IMU_CAL_UPRIGHT):
        if not 0 <= orientation <= 255 or not lib.imu_cal_orientation_is_lawful(orientation):
            raise ValueError(f"no orientation {orientation} in imu_cal.h")
        self.orientation = orientation

    def apply(self, vector_counts: Sequence[int]) -> tuple[int, int, int]:
        """Turn one vector."""
        vector = ffi.new("int16_t[3]", [int(each) for each in vector_counts])
        lib.imu_cal_turn(self.orientation, vector)
        return tuple(vector)

    def block(self, vectors_counts) -> np.ndarray:
        """Turn (n, 3) vectors; gives (n, 3) int16."""
        turned = int16_vectors(vectors_counts, "vectors").copy()
        lib.imu_blocks_turn(self.orientation, pointer(turned), len(turned))
        return turned


class Rest(CState):
    """Stillness and the gyroscope's bias (rest.h).

    config : name of a rate of rest.toml, or fields of rest_config_t, as
        terazi.design.rest.config_at makes them for any rate.
    """

    def __init__(self, config: str | Mapping[str, int]):
        if isinstance(config, str):
            if config not in REST_RATES:
                raise ValueError(f"no rate {config!r}; there are {', '.join(REST_RATES)}")
            self._config = ffi.addressof(lib, f"rest_{config}")
        else:
            try:
                self._config = ffi.new("rest_config_t *", rest_design.as_c(config))
            except OverflowError as error:
                raise ValueError(f"configuration of rest: {error}") from None
            if not lib.rest_is_lawful(self._config):
                raise ValueError(f"configuration of rest is beyond rest.h: {dict(config)}")
        self._c = ffi.new("rest_t *")
        lib.rest_init(self._c, self._config)

    @property
    def c_state(self):
        """rest_t, for block functions that take it along."""
        return self._c

    @property
    def bias_q16(self) -> tuple[int, int, int]:
        """The gyroscope's bias in counts Q16."""
        return tuple(self._c.bias_q16)

    @property
    def rejected(self) -> int:
        """Samples on a rail so far, stops at 65535."""
        return self._c.rejected

    @property
    def implausible(self) -> int:
        """Blocks that were not learnt, stops at 65535."""
        return self._c.implausible

    def interrupt(self) -> None:
        """Samples were lost: rest must begin anew."""
        lib.rest_interrupt(self._c)

    def update(self, gyro_b_counts: Sequence[int], acc_b_counts: Sequence[int]) -> int:
        """Take one sample; gives AT_REST and BIAS_KNOWN as bits."""
        gyro, acc = (
            ffi.new("int16_t[3]", [int(e) for e in v]) for v in (gyro_b_counts, acc_b_counts)
        )
        return lib.rest_update(self._c, gyro, acc)

    def block(self, gyro_b_counts, acc_b_counts) -> tuple[np.ndarray, np.ndarray]:
        """Take (n, 3) samples; gives (n, 3) int32 bias in Q16 and (n,) uint8 flags after each."""
        gyro = int16_vectors(gyro_b_counts, "gyroscope values")
        acc = int16_vectors(acc_b_counts, "accelerometer values")
        if len(gyro) != len(acc):
            raise ValueError(f"{len(gyro)} gyroscope and {len(acc)} accelerometer values")
        bias_q16 = np.empty((len(gyro), 3), dtype=np.int32)
        flags = np.empty(len(gyro), dtype=np.uint8)
        lib.imu_blocks_rest(
            self._c, pointer(gyro), pointer(acc), pointer(bias_q16), pointer(flags), len(gyro)
        )
        return bias_q16, flags
