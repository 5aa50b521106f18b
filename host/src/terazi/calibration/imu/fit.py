# SPDX-License-Identifier: MIT
"""Settings of accelerometer and gyroscope from a board that lay in several positions.

All residuals are those of the shipped integer imu_cal on the raw samples, with the settings of
before and of after.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from terazi.applications.attitude.calibrated import measured
from terazi.applications.attitude.records import Record
from terazi.calibration.imu import positions
from terazi.calibration.imu.accelerometer import AccelerometerFit, fit_accelerometer
from terazi.calibration.imu.axes import find_mag_axes
from terazi.calibration.imu.gyroscope import GyroscopeFit, Turn, fit_gyroscope, turned_wrong
from terazi.calibration.imu.magnetometer import MagnetometerFit, fit_magnetometer
from terazi.calibration.imu.quantise import settings_of
from terazi.calibration.imu.standstill import Standstill
from terazi.errors import CalibrationRefused
from terazi.units import ACC_COUNTS_PER_STANDARD_GRAVITY as ONE_G
from terazi.units import GYRO_COUNTS_PER_DEG_S

SCALE_WITHIN = 0.15  # of a part that is what it is taken for
CONTRADICTS_G = 0.004  # a position whose length is off by more, after the fit
OPEN_OFFSET_G, OPEN_SCALE = 0.005, 0.005  # sigmas beyond these: the positions do not tell
GOOD_OFFSET_G, GOOD_SCALE, GOOD_CROSS = 0.001, 0.001, 0.003
BIAS_MOST_DEG_S = 40.0  # +-20 deg/s at 25 degC, and as much by temperature
BIAS_WANDERS_DEG_S = 1.0
GAP_PERIODS = 1.5


class Contradiction(CalibrationRefused):
    """`worst` is the index of the standstill that does not go with the others."""

    def __init__(self, worst: int, message: str, *, remedy: str) -> None:
        super().__init__(message, remedy=remedy)
        self.worst = worst


@dataclass(frozen=True)
class Position:
    """One standstill, in words and numbers."""

    name: str
    seconds: float
    before_g: float  # length less 1
    after_g: float


@dataclass
class MotionResult:
    """What a sitting gave; settings are by name."""

    settings: dict[str, int]
    positions: list[Position]
    acc: AccelerometerFit
    gyro: GyroscopeFit
    bias_before_deg_s: np.ndarray  # (3,) as the device measured it, and will
    bias_after_deg_s: np.ndarray
    turns_before_deg: float  # rms of what gravity was missed by; NaN without turns
    turns_after_deg: float
    notes: list[str] = field(default_factory=list)

    def rms_g(self, which: str) -> float:
        """before_g or after_g over all positions."""
        values = np.array([getattr(one, which) for one in self.positions])
        return float(np.sqrt(np.mean(values**2)))


def fit_motion(
    record: Record,
    stills: Sequence[Standstill],
    before: Mapping[str, int],
    *,
    free: bool = False,
) -> MotionResult:
    """Accelerometer and gyroscope. Raises CalibrationRefused, which names what to do.

    record : all samples, of which stills are.
    before : acc.* and gyro.* as the device holds them.
    free : the positions need be no faces.
    """
    want_positions(stills, free=free)
    sigma_g = np.array([_sigma_g(record, one) for one in stills])
    acc = fit_accelerometer(np.array([one.acc_counts for one in stills]), sigma_g)
    notes = _judge_accelerometer(acc, stills, sigma_g, free)
    settings = settings_of("acc", acc.constants)
    ups = [_unit(acc.constants.apply(one.acc_counts)) for one in stills]
    biases = np.array([one.gyro_counts for one in stills])
    lengths = np.array([one.last - one.first for one in stills])
    bias = np.average(biases, axis=0, weights=lengths)
    notes += _judge_bias(biases, bias)
    turns = _turns(record, stills, ups)
    gyro = fit_gyroscope(turns, bias)
    if gyro.why_not:
        notes.append(
            f"the gyroscope's scale and axes stay as the factory made them: {gyro.why_not}"
        )
    settings |= settings_of("gyro", gyro.constants)
    both = (before, settings)
    bias_deg_s = [_bias_deg_s(record, stills, each) for each in both]
    turned_deg = [_turned_deg(record, stills, ups, each) for each in both]
    return MotionResult(
        settings=settings,
        positions=[_position(record, one, before, settings) for one in stills],
        acc=acc,
        gyro=gyro,
        bias_before_deg_s=bias_deg_s[0],
        bias_after_deg_s=bias_deg_s[1],
        turns_before_deg=turned_deg[0],
        turns_after_deg=turned_deg[1],
        notes=notes,
    )


def want_positions(stills: Sequence[Standstill], *, free: bool) -> None:
    """Raises CalibrationRefused where too few were taken, or all of another scale."""
    lengths = [float(np.linalg.norm(one.acc_counts) / ONE_G) for one in stills]
    if lengths and not abs(np.median(lengths) - 1) < SCALE_WITHIN:
        raise CalibrationRefused(
            f"at rest the accelerometer measures {np.median(lengths):.2f} g: another scale",
            remedy="Its range must be +-16 g, 2048 counts a g. Is it an MPU-6050, and imu.mode "
            "hz_500?",
        )
    ups = [one.up for one in stills]
    if free:
        there = len(positions.distinct(ups))
        if there < positions.FREE_POSITIONS:
            raise CalibrationRefused(
                f"{there} positions that differ are too few, {positions.FREE_POSITIONS} are wanted",
                remedy=f"Next, for example: {positions.emptiest(ups)}.",
            )
        return
    missing = positions.missing_faces(ups)
    if missing:
        raise CalibrationRefused(
            f"of the six positions {', '.join(missing)} {'are' if missing[1:] else 'is'} missing "
            f"({len(stills)} standstills were seen)",
            remedy=f"Let it lie for 3 s each: {positions.hint(missing, ups)}.",
        )


def _judge_accelerometer(acc, stills, sigma_g: np.ndarray, free: bool) -> list[str]:
    """Notes; raises where the positions contradict one another or leave too much open."""
    if np.abs(acc.residuals_g).max() > CONTRADICTS_G:
        worst, off_g = _odd_one(stills, sigma_g)
        raise Contradiction(
            worst,
            "the positions contradict one another: by the others gravity is off by "
            f"{off_g * 1000:+.1f} mg at “{positions.name_of(stills[worst].up)}”",
            remedy="It moved or was held there. Do it again, on a table that stands firm.",
        )
    if acc.offset_sd_g > OPEN_OFFSET_G or acc.scale_sd > OPEN_SCALE:
        raise CalibrationRefused(
            f"the positions leave the offset open by {acc.offset_sd_g * 1000:.1f} mg and the scale "
            f"by {acc.scale_sd:.2%}: they lie too much alike",
            remedy="Turn it further from one position to the next"
            + ("." if free else ", nearer to straight up and down, and add some at a slant."),
        )
    notes = []
    if acc.cross_sd > GOOD_CROSS:
        slanted = ", ".join(positions.missing_slants([one.up for one in stills]))
        notes.append(
            f"cross axes are known to {acc.cross_sd:.1%} only: positions at a slant tell them"
            + (f" ({slanted})" if slanted else "")
        )
    if acc.offset_sd_g > GOOD_OFFSET_G or acc.scale_sd > GOOD_SCALE:
        notes.append(
            f"one sigma: {acc.offset_sd_g * 1000:.1f} mg of offset, {acc.scale_sd:.2%} of scale"
        )
    return notes


def _odd_one(stills, sigma_g: np.ndarray) -> tuple[int, float]:
    """The position without which the others go together best, and how far off it is by them."""
    means = np.array([one.acc_counts for one in stills])
    left = []
    for at in range(len(stills)):
        others = np.arange(len(stills)) != at
        fit = fit_accelerometer(means[others], sigma_g[others])
        off_g = float(np.linalg.norm(fit.constants.apply(means[at])) / ONE_G - 1)
        left.append((float(np.sum(fit.residuals_g**2)), at, off_g))
    _sum, worst, off_g = min(left)
    return worst, off_g


def _judge_bias(biases: np.ndarray, bias: np.ndarray) -> list[str]:
    most = float(np.abs(bias).max() / GYRO_COUNTS_PER_DEG_S)
    if most > BIAS_MOST_DEG_S:
        raise CalibrationRefused(
            f"lying still the gyroscope turns by {most:.0f} deg/s",
            remedy="It turns, or the part is broken: try `terazi calibrate --imu --self-test`.",
        )
    wanders = float(np.ptp(biases, axis=0).max() / GYRO_COUNTS_PER_DEG_S)
    if wanders > BIAS_WANDERS_DEG_S:
        raise CalibrationRefused(
            f"the gyroscope's bias moves by {wanders:.1f} deg/s between the standstills",
            remedy="Something turned while it lay, or it warms up: leave it on for ten minutes.",
        )
    return []


def _sigma_g(record: Record, still: Standstill) -> float:
    """Of a mean length, by the samples' own spread."""
    samples = record.acc_b_counts[still.first : still.last] / ONE_G
    return float(np.linalg.norm(samples.std(axis=0)) / np.sqrt(3 * len(samples)))


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def _position(record, still, before, after) -> Position:
    raw = record.acc_b_counts[still.first : still.last]
    off = [
        float(np.linalg.norm(measured("acc", each, raw).mean(axis=0)) / ONE_G - 1)
        for each in (before, after)
    ]
    seconds = (still.last - still.first) / record.rate_hz
    return Position(positions.name_of(still.up), seconds, *off)


def _turns(record: Record, stills, ups, settings=None) -> list[Turn]:
    """What lies between neighbouring standstills without a lost sample."""
    rates = record.gyro_b_counts
    if settings is not None:
        rates = measured("gyro", settings, rates)
    turns = []
    for (one, up_before), (other, up_after) in pairwise(zip(stills, ups, strict=True)):
        first, last = one.end - 1, other.first + 1
        if np.diff(record.number[first:last]).max() > GAP_PERIODS * record.every:
            continue
        bias_one, bias_other = (rates[s.first : s.last].mean(axis=0) for s in (one, other))
        share = np.linspace(0.0, 1.0, last - first)[:, None]
        bias = bias_one * (1 - share) + bias_other * share
        turns.append(Turn(rates[first:last], bias, 1 / record.rate_hz, up_before, up_after))
    return turns


def _bias_deg_s(record: Record, stills, settings) -> np.ndarray:
    parts = [record.gyro_b_counts[one.first : one.last] for one in stills]
    rates = measured("gyro", settings, np.concatenate(parts))
    return rates.mean(axis=0) / GYRO_COUNTS_PER_DEG_S


def _turned_deg(record: Record, stills, ups, settings) -> float:
    turns = _turns(record, stills, ups, settings)
    if not turns:
        return float("nan")
    missed = [np.linalg.norm(turned_wrong(turn, np.eye(3))) for turn in turns]
    return float(np.degrees(np.sqrt(np.mean(np.square(missed)))))


def relate(
    record: Record,
    stills: Sequence[Standstill],
    motion: MotionResult,
    field: FieldResult,
    present: Mapping[str, int],
) -> None:
    """How the magnetometer sits beside the IMU, into the field's settings and notes.

    present : imu.orientation and mag.orientation; without them nothing is said.
    """
    codes = [present.get(f"{part}.orientation") for part in ("imu", "mag")]
    if record.mag_b_counts is None or None in codes:
        return
    ups = [motion.acc.constants.apply(one.acc_counts) for one in stills]
    means = [record.mag_b_counts[one.first : one.last].mean(axis=0) for one in stills]
    fields = [field.mag.constants.apply(mean) for mean in means]
    axes = find_mag_axes([_unit(up) for up in ups], fields, *codes)
    if axes is None:
        return
    if axes.is_wrong:
        field.settings["mag.orientation"] = axes.best
    if axes.note:
        field.notes.append(axes.note)


@dataclass
class FieldResult:
    """What turning a magnetometer about gave: spread of the field's length, in shares of it."""

    settings: dict[str, int]
    mag: MagnetometerFit
    rms_before: float
    rms_after: float
    worst_before: float
    worst_after: float
    notes: list[str] = field(default_factory=list)


def fit_field(raw_counts: np.ndarray, before: Mapping[str, int]) -> FieldResult:
    """Magnetometer. raw_counts : (n, 3) int16. Raises CalibrationRefused."""
    mag = fit_magnetometer(raw_counts)
    settings = settings_of("mag", mag.constants)
    figures = []
    for each in (before, settings):
        lengths = np.linalg.norm(measured("mag", each, raw_counts).astype(np.float64), axis=1)
        shares = lengths / lengths.mean() - 1
        figures.append((float(np.sqrt(np.mean(shares**2))), float(np.abs(shares).max())))
    notes = []
    if mag.left_out:
        notes.append(f"{mag.left_out} samples of a disturbed field were left out of the fit")
    (rms_before, worst_before), (rms_after, worst_after) = figures
    return FieldResult(settings, mag, rms_before, rms_after, worst_before, worst_after, notes)
