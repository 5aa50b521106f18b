# SPDX-License-Identifier: MIT
"""What IMU_STATUS and ATTITUDE tell, in words for people."""

import math

import numpy as np

from terazi import rotation, units
from terazi.link.generated.messages import Attitude, AttitudeFlag, ImuState, ImuStatus, MagKind

MPU6050 = 0x68  # WHO_AM_I, register map 4.32
# As Linux's driver inv_mpu6050 knows them (inv_mpu_iio.h); sold on boards as MPU-6050.
SIBLINGS = {0x70: "MPU-6500", 0x71: "MPU-9250", 0x73: "MPU-9255", 0x74: "MPU-6515"}
SIBLINGS |= {0x78: "MPU-6880", 0x98: "ICM-20689", 0x12: "ICM-20602", 0xAF: "ICM-20608"}

MAGNETOMETERS = {MagKind.NONE: "no magnetometer"}
MAGNETOMETERS |= {kind: f"magnetometer {kind.name}" for kind in MagKind if kind}

# Counters that stand above zero where something was lost or beyond a range.
COUNTERS = (
    *("missed", "overruns", "losses", "bus_recoveries", "clipped", "rest_rejected", "acc_zero"),
    *("railed", "mag_refused", "mag_disturbed", "gaps"),
)

NO_SCALE_DEG = 30.0

FLAG_WORDS = {
    AttitudeFlag.REST: "at rest",
    AttitudeFlag.STILL: "still",
    AttitudeFlag.BIAS_KNOWN: "bias known",
    AttitudeFlag.HEADING: "heading",
    AttitudeFlag.DISTURBED: "field disturbed",
    AttitudeFlag.GAP: "samples lost",
    AttitudeFlag.RAILED: "beyond its range",
    AttitudeFlag.RESTARTED: "started anew",
}
ALARMING = AttitudeFlag.DISTURBED | AttitudeFlag.GAP | AttitudeFlag.RAILED | AttitudeFlag.RESTARTED


def part_words(status: ImuStatus) -> str:
    """MPU-6050 (WHO_AM_I 0x68) running, 31.4 °C."""
    name = "MPU-6050"
    if status.identity != MPU6050:
        name = SIBLINGS.get(status.identity, "MPU-6050's sibling")
    words = f"{name} (WHO_AM_I 0x{status.identity:02X}) {state_words(status)}"
    if status.state != ImuState.RUNNING:
        return words
    return f"{words}, {units.deg_c_from_counts(status.temp_counts):.1f} °C"


def state_words(status: ImuStatus) -> str:
    """What the driver knows of the part."""
    name = getattr(status.state, "name", f"state {status.state}")
    return name.lower()


def identity_warning(status: ImuStatus) -> str:
    """A word of warning where the part is a sibling; "" where it is what it should be."""
    if status.identity == MPU6050 or status.state == ImuState.ABSENT:
        return ""
    name = SIBLINGS.get(status.identity)
    sibling = f"that of an {name}" if name else "no MPU-6050's"
    return (
        f"WHO_AM_I is 0x{status.identity:02X}, {sibling}: it is used as an MPU-6050; "
        "temperature and noise may differ"
    )


def magnetometer_words(status: ImuStatus) -> str:
    """Which one is on the bus."""
    return MAGNETOMETERS.get(status.mag_kind, f"magnetometer of kind {int(status.mag_kind)}")


def trouble(status: ImuStatus) -> dict[str, int]:
    """Counters that are not at zero, by name in words; the start is no gap."""
    found = {name: getattr(status, name) for name in COUNTERS}
    found["gaps"] = max(found["gaps"] - 1, 0)
    return {name.replace("_", " "): value for name, value in found.items() if value}


def bias_deg_s(status: ImuStatus) -> tuple[float, float, float]:
    """The gyroscope's bias as learnt at rest, body axes."""
    x, y, z = (units.deg_s_from_q16(getattr(status, f"bias_{axis}_q16")) for axis in "xyz")
    return x, y, z


def tilt_deg(status: ImuStatus) -> float:
    """How far the board's z stands off the vertical."""
    return units.tilt_deg([getattr(status, f"up_{axis}_q14") for axis in "xyz"])


def tilt_words(tilt: float) -> str:
    """A tilt in degrees, and what a scale makes of it."""
    if tilt > NO_SCALE_DEG:
        return f"{tilt:.1f}° off the vertical: no scale stands so"
    share = 1.0 - math.cos(math.radians(tilt))
    return f"{tilt:.2f}° off the vertical: a scale weighs {100 * share:.3f} % too little"


def angles_deg(attitude: Attitude) -> tuple[float, float, float]:
    """Roll, pitch and yaw; zeros where there is no attitude yet."""
    quat_q30 = np.array([[getattr(attitude, f"quat_{axis}_q30") for axis in "wxyz"]])
    if not quat_q30.any():
        return 0.0, 0.0, 0.0
    roll, pitch, yaw = rotation.euler_deg(quat_q30)[0].tolist()
    return roll, pitch, yaw


def attitude_words(attitude: Attitude) -> str:
    """roll   -0.1°  pitch   +1.5°  yaw   +90.0°."""
    angles = zip(("roll", "pitch", "yaw"), angles_deg(attitude), strict=True)
    return "  ".join(f"{name} {angle + 0.0:+7.1f}°" for name, angle in angles)


def flag_words(flags: int) -> list[str]:
    """Each flag of ATTITUDE in words."""
    return [words for flag, words in FLAG_WORDS.items() if flags & flag]
