# SPDX-License-Identifier: MIT
"""What makes the chip run imu_cal and rest with all sorts of data: their golden vectors."""

from __future__ import annotations

from target_vectors import avr_imu
from target_vectors.avr_core import AvrCore
from terazi.models.vectors import Vector, golden


def _rows(vector: Vector, *columns: str) -> list[tuple[int, ...]]:
    return list(zip(*(vector[column] for column in columns), strict=True))


def drive_imu_cal(core: AvrCore) -> None:
    """Usual and extreme constants, rails included."""
    for vector in golden("imu_cal_apply_"):
        constants = (
            [int(word) for word in vector.parameters[name].split()]
            for name in ("matrix_q16", "offset_q3")
        )
        avr_imu.imu_cal_init(core, *constants)
        avr_imu.imu_cal_apply(core, _rows(vector, *(f"raw_{axis}_counts" for axis in "xyz")))


def drive_imu_turn(core: AvrCore) -> None:
    """Each orientation."""
    for vector in golden("imu_cal_turn"):
        columns = ("orientation", *(f"part_{axis}_counts" for axis in "xyz"))
        for orientation, *counts in _rows(vector, *columns):
            avr_imu.imu_cal_turn(core, orientation, counts)


def drive_rest(core: AvrCore) -> None:
    """Motion, rest, blocks learnt and refused, rails."""
    for vector in golden("rest_"):
        names = (f"{sensor}_{axis}_counts" for sensor in ("gyro", "acc") for axis in "xyz")
        config = {field: vector.parameter(field) for field in avr_imu.REST_LAYOUT}
        avr_imu.rest(core, config, _rows(vector, *names))
