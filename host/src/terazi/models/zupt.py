# SPDX-License-Identifier: MIT
"""Float64 truth for zupt.c."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from terazi.design import zupt as design

STANDARD_GRAVITY_M_S2 = design.STANDARD_GRAVITY_M_S2
VALUE_MAX = 4096


@dataclass(frozen=True)
class ZuptResult:
    """What zupt gives after each sample."""

    still: np.ndarray  # (n,) bool
    motion: np.ndarray  # (b,) root of the mean square of each whole block, in the limits' unit
    rejected: int
    margin: float  # least distance of a block's sum of squares from its limit, in counts^2, less
    #                what rounding may move it: where it is positive, the C decides alike


def zupt(gyro_b_rad_s, acc_b_m_s2, *, detector, rate_hz, classical=False, **changed):
    """Float64 truth for ``zupt_update`` over a run of samples.

    gyro_b_rad_s, acc_b_m_s2 : (n, 3) float64, uniform sampling. NaN, infinities and values at or
        beyond what the sensor can say are rejected and counted.
    detector : name of zupt.toml.  changed : keys of it with another value.
    classical : ``| |a| - g |`` by its root, as Skog et al. have it, not to first order.
    Returns a ZuptResult.

    Nothing is rounded. shared_c/notes/zupt.md bounds by how much the C's sums may differ.
    """
    entry = design.entry_of(detector, **changed)
    sensor = design.spec()["sensor"]
    acc_scale = sensor["acc_counts_per_g"] / STANDARD_GRAVITY_M_S2
    gyro_scale = np.degrees(sensor["gyro_counts_per_deg_s"])
    unit = design.counts_per_unit(detector, sensor)
    name = "rad_s" if design.turns(detector) else "m_s2"
    factor = design.squares_per_count2(entry, sensor)
    limits = [factor * (entry[f"{side}_{name}"] * unit) ** 2 for side in ("enter", "leave")]
    stride = design.config_at(detector, rate_hz, **changed)["stride"]
    weight = design.gyro_weight(entry, sensor)
    sensors = {"acc": np.asarray(acc_b_m_s2) * acc_scale, "gyro": gyro_b_rad_s * gyro_scale}
    looked = {"acc": detector != "are", "gyro": weight > 0}

    flags, motion, margin = np.zeros(len(gyro_b_rad_s), dtype=bool), [], np.inf
    still, quiet, visit, rejected = False, 0, 0, 0
    block: dict[str, list] = {"acc": [], "gyro": []}
    for n in range(len(flags)):
        moved = judged = False
        if n % stride == 0 and visit == design.VISITS - 1:
            acc, gyro = (np.array(block[which]) for which in ("acc", "gyro"))
            squares = _squares(detector, acc, gyro, weight, classical)
            motion.append(np.sqrt(squares / factor) / unit)
            limit = limits[int(still)]
            margin = min(margin, abs(squares - limit) - _rounding(detector, squares))
            moved, judged = squares >= limit, True
        elif n % stride == 0:
            which = ("acc", "gyro")[visit % 2]
            visit += 1
            if looked[which]:
                vector = sensors[which][n]
                block[which].append(vector)
                beyond = ~(np.abs(vector + 0.5) < VALUE_MAX)
                moved = bool(beyond.any())
                if moved:
                    rejected += not abs(vector[np.argmax(beyond)]) < 32766.5
        if judged and not moved and not still:
            quiet += 1
            still = quiet == entry["still_blocks"]
        if moved:
            still, quiet = False, 0
        if moved or judged:
            visit, block = 0, {"acc": [], "gyro": []}
        flags[n] = still
    return ZuptResult(flags, np.array(motion), rejected, float(margin))


def _squares(detector, acc, gyro, weight, classical) -> float:
    """A block's sum of squares, in counts^2."""
    turning = weight * np.sum(gyro**2) if len(gyro) else 0.0
    if detector == "are":
        return turning
    if detector == "magnitude":
        return design.MAGNITUDE_FACTOR * np.sum(_off(np.sum(acc**2, axis=1), classical) ** 2)
    mean = acc.mean(axis=0)
    spread = np.sum((acc - mean) ** 2)
    if detector == "moving_variance":
        return spread
    return turning + spread + len(acc) * _off(mean @ mean, classical) ** 2


def _off(square, classical):
    """How far a vector of this square is from gravity, in counts."""
    gravity = design.GRAVITY_COUNTS
    return np.sqrt(square) - gravity if classical else (square - gravity**2) / (2 * gravity)


def _rounding(detector: str, squares: float) -> float:
    """How far the C's sum may lie from this one, in counts^2, from whole counts at the input.

    A bracket is rounded down by less than one count: (e - 1)^2 - e^2 < 2 |e| + 1, and half a
    count^2 stands for the limit's own rounding.
    """
    if detector == "are":
        return 0.5
    if detector == "moving_variance":
        return 1.5
    # shoe: 4 e^2 <= squares, hence 4 (2 |e| + 1) <= 4 sqrt(squares) + 4; magnitude: four such
    # brackets, whose sum of |e| is largest where they are equal: 4 e^2 = squares / 4 each.
    bracket = 4 * np.sqrt(squares) + 4
    return bracket + 1.5 if detector == "shoe" else 2 * bracket + 8 + 0.5
