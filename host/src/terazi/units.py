# SPDX-License-Identifier: MIT
"""Between the wire's integers and the units that people read. Every conversion stands here once.

The functions take scalars and numpy arrays alike. Names: `_qN` means N fraction bits.
"""

import math

COUNTS_RAIL_LOW = -(1 << 23)
COUNTS_RAIL_HIGH = (1 << 23) - 1
KF_ONE_COUNT_Q7 = 1 << 7
Q16_ONE = 1 << 16

US_PER_S = 1_000_000
UG_PER_G = 1_000_000
MG_PER_G = 1_000

# The MPU-6050 at +-2000 deg/s and +-16 g (datasheet 6.1, 6.2); as mahony.toml has it.
GYRO_COUNTS_PER_DEG_S = 16.384
ACC_COUNTS_PER_STANDARD_GRAVITY = 2048.0
STANDARD_GRAVITY_M_S2 = 9.80665
TEMP_COUNTS_PER_K, TEMP_ZERO_DEG_C = 340.0, 36.53  # register map 4.18


def counts_from_q7(counts_q7):
    """Converter counts from the Kalman filter's Q7."""
    return counts_q7 / KF_ONE_COUNT_Q7


def hz_from_q16(rate_hz_q16):
    """A rate in Hz from Q16; 0 stands for "not known yet"."""
    return rate_hz_q16 / Q16_ONE


def g_from_mg(mass_mg):
    """Gram from milligram."""
    return mass_mg / MG_PER_G


def s_from_us(time_us):
    """Seconds from microseconds."""
    return time_us / US_PER_S


def one_from_q30(value_q30):
    """A number of Q30, as a quaternion's, in ones."""
    return value_q30 / (1 << 30)


def one_from_q14(value_q14):
    """A number of Q14 in ones."""
    return value_q14 / (1 << 14)


def deg_s_from_q16(gyro_q16):
    """A turn rate in degrees a second from the gyroscope's counts in Q16."""
    return gyro_q16 / Q16_ONE / GYRO_COUNTS_PER_DEG_S


def deg_s_from_counts(gyro_counts):
    """A turn rate in degrees a second from the gyroscope's counts."""
    return gyro_counts / GYRO_COUNTS_PER_DEG_S


def m_s2_from_counts(acc_counts):
    """An acceleration from the accelerometer's counts."""
    return acc_counts * (STANDARD_GRAVITY_M_S2 / ACC_COUNTS_PER_STANDARD_GRAVITY)


def deg_c_from_counts(temp_counts):
    """The temperature of the MPU-6050 itself."""
    return temp_counts / TEMP_COUNTS_PER_K + TEMP_ZERO_DEG_C


def tilt_deg(up_b) -> float:
    """How far body z stands off the vertical: (3,), the vertical in body axes, of any norm."""
    x, y, z = up_b
    return math.degrees(math.atan2(math.hypot(x, y), z))


def show_g(weight_g: float) -> str:
    """A weight for people, to the hundredth of a gram."""
    return f"{weight_g:,.2f} g".replace(",", " ")


def show_bytes(size_bytes: int) -> str:
    """A size for people: 512 B, 1.2 kB, 3.4 MB."""
    size = float(size_bytes)
    for unit in ("B", "kB", "MB", "GB"):
        if size < 1000 or unit == "GB":
            return f"{size:.0f} B" if unit == "B" else f"{size:.1f} {unit}"
        size /= 1000
    raise AssertionError("unreachable")


def show_duration(duration_s: float) -> str:
    """A duration for people: 12.3 s, 4 min 05 s, 2 h 03 min."""
    if duration_s < 59.95:
        return f"{duration_s:.1f} s"
    minutes, seconds = divmod(round(duration_s), 60)
    if minutes < 60:
        return f"{minutes} min {seconds:02d} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min"
