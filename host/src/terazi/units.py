# SPDX-License-Identifier: MIT
"""Between the wire's integers and the units that people read. Every conversion stands here once.

The functions take scalars and numpy arrays alike. Names: `_qN` means N fraction bits.
"""

COUNTS_RAIL_LOW = -(1 << 23)
COUNTS_RAIL_HIGH = (1 << 23) - 1
KF_ONE_COUNT_Q7 = 1 << 7
Q16_ONE = 1 << 16

US_PER_S = 1_000_000
UG_PER_G = 1_000_000
MG_PER_G = 1_000


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
