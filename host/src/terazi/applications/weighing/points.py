# SPDX-License-Identifier: MIT
"""A capture as a test of the scale: what it read at each load, in e, beside class III.

Definitions, which the page repeats:
  placement  from one change of load to the next; its reading is the mean of the net weight over
             its samples that were marked stable (or, if none was, over its settled part)
  error      reading less true load; sigma: of single samples about that mean, pooled
  bound      what the mean of a placement's raw samples can be known to: their sigma / sqrt(N)
  floor      the converter's own noise, by its datasheet, as a sigma of single samples
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from terazi import units
from terazi.applications.weighing.limits import IN_SERVICE, permitted_error_e
from terazi.design import scale as design
from terazi.errors import UsageError
from terazi.link.generated.messages import Setting, WeightFlag
from terazi.link.generated.settings import SettingKey
from terazi.recorder.calibration import calibration_of
from terazi.recorder.recording import Recording
from terazi.report.analysis import Analysis, noise_rms

NEAR_SHARE = 0.25  # of the way to the next true load: further off it belongs to neither
SAME_LOAD_E = 20.0  # readings within it are one load, where nobody says what lay there
SAMPLES_LEAST = 8
FLOOR_COUNTS = ((20.0, 21.5), (np.inf, 38.7))  # up to so many SPS; HX711 datasheet p. 3


@dataclass(frozen=True)
class Placement:
    """One load, put on once. Weights in gram."""

    t_s: float  # when it came
    begin: int  # of the samples that count, [begin, end)
    end: int
    reading_g: float
    sigma_g: float  # of single samples
    raw_sigma_g: float
    samples: int
    is_stable: bool  # some sample was marked so
    stable_after_s: float | None  # from the change of load; None: never, or no change
    direction: str  # "up" or "down" from the one before, "first"
    load_g: float | None  # what lay there


@dataclass(frozen=True)
class Point:
    """All placements of one load, in e but for the load itself."""

    load_g: float
    is_known: bool  # somebody said that this lay there; else its mean reading
    placements: int
    samples: int
    mean_error_e: float | None
    worst_error_e: float | None
    sigma_e: float
    repeatability_e: float  # greatest less least reading
    hysteresis_e: float | None  # readings coming down less those going up
    bound_e: float
    limit_e: float  # at verification
    limit_in_service_e: float
    within: bool | None
    within_in_service: bool | None


@dataclass(frozen=True)
class Weighing:
    """What `terazi weigh FILE` found."""

    e_g: float
    max_g: float
    rate_hz: float
    floor_e: float
    placements: list[Placement]
    points: list[Point]

    @property
    def within(self) -> bool | None:
        """None where no load is known."""
        known = [point.within for point in self.points if point.within is not None]
        return all(known) if known else None


def setting_of(recording: Recording, key: SettingKey) -> int | None:
    """The first value that the recording tells of a setting."""
    for _at, received in recording.of_kind(Setting):
        if received.message.key == key:
            return received.message.value
    return None


def interval_g(recording: Recording) -> float:
    """e as the capture tells it, or else the factory's."""
    found = setting_of(recording, SettingKey.SCALE_INTERVAL_MG)
    return units.g_from_mg(design.config()["interval_mg"] if found is None else found)


def max_load_g(recording: Recording) -> float:
    """Max as the capture tells it, or else the factory's."""
    found = setting_of(recording, SettingKey.SCALE_MAX_MG)
    return units.g_from_mg(design.config()["max_mg"] if found is None else found)


def mg_per_count(recording: Recording) -> float:
    """The mean slope of the calibration that came first, or of the nominal cell."""
    for stretch in calibration_of(recording):
        if stretch.points is not None:
            (low_q7, low_mg), *_rest, (high_q7, high_mg) = stretch.points
            return abs((high_mg - low_mg) / units.counts_from_q7(high_q7 - low_q7))
    (_zero, _nothing), (counts, mass_g) = design.default_points()
    return mass_g * units.MG_PER_G / counts


def placements_of(recording: Recording, analysis: Analysis) -> list[Placement]:
    """Each stretch between changes of load that is long enough to read."""
    t_s, net_g = analysis.t_s, units.g_from_mg(recording.samples["net_mg"].astype(np.float64))
    stable = (recording.samples["weight_flags"] & int(WeightFlag.STABLE)) != 0
    found: list[Placement] = []
    for number, (begin, end) in enumerate(analysis.spans):
        settled = analysis.settled[number]
        here = begin + np.flatnonzero(stable[begin:end])
        # The first flagged samples may still be of the load before, until the filters tell.
        fell = begin + int(np.argmin(stable[begin:end])) if end > begin else begin
        after = here[here >= fell] if number and not stable[begin:end].all() else here
        used = after if len(after) >= SAMPLES_LEAST else np.arange(*settled)
        if len(used) < SAMPLES_LEAST:
            continue
        reading_g = float(net_g[used].mean())
        before_g = found[-1].reading_g if found else None
        direction = "first" if before_g is None else "up" if reading_g > before_g else "down"
        raw_g = analysis.stages_g["raw"]
        found.append(
            Placement(
                t_s=float(t_s[begin]),
                begin=int(used[0]),
                end=int(used[-1]) + 1,
                reading_g=reading_g,
                sigma_g=float(net_g[used].std(ddof=1)),
                raw_sigma_g=noise_rms(raw_g, [settled]) if settled[1] - settled[0] > 2 else np.nan,
                samples=len(used),
                is_stable=len(after) >= SAMPLES_LEAST,
                stable_after_s=float(t_s[after[0]] - t_s[begin]) if number and len(after) else None,
                direction=direction,
                load_g=None,
            )
        )
    return found


def nearest_loads(placements: Sequence[Placement], loads_g: Sequence[float]) -> list[float]:
    """What lay there each time: the nearest of the loads. Raises UsageError where none is near."""
    distinct = np.unique(np.asarray(loads_g, dtype=np.float64))
    chosen = []
    for one in placements:
        away = np.abs(distinct - one.reading_g)
        nearest = int(np.argmin(away))
        gaps = np.abs(np.delete(distinct, nearest) - distinct[nearest])
        if len(gaps) and away[nearest] > NEAR_SHARE * gaps.min():
            raise UsageError(
                f"{one.reading_g:.1f} g at {one.t_s:.1f} s is none of the loads given: the nearest "
                f"is {distinct[nearest]:g} g",
                remedy="Give every load that lay on the scale, 0 too: --load-g 0,500,1000",
            )
        chosen.append(float(distinct[nearest]))
    return chosen


def _true_load(analysis: Analysis, one: Placement) -> float:
    """What the truth says of a placement. Raises UsageError where it is silent."""
    told_g = analysis.truth_g[one.begin : one.end]
    told_g = told_g[np.isfinite(told_g)]
    if not len(told_g):
        raise UsageError(f"the truth does not say what lay there at {one.t_s:.1f} s")
    return float(np.median(told_g))


def _alike(placements: Sequence[Placement], e_g: float) -> list[float]:
    """Where nobody says what lay there: the mean of readings that are close to each other."""
    order = np.argsort([one.reading_g for one in placements])
    readings = np.array([one.reading_g for one in placements])[order]
    group = np.concatenate([[0], np.cumsum(np.diff(readings) > SAME_LOAD_E * e_g)])
    means = np.array([readings[group == at].mean() for at in range(group[-1] + 1)])
    loads = np.empty(len(order))
    loads[order] = means[group]
    return loads.tolist()


def _point(load_g: float, group: list[Placement], is_known: bool, e_g: float) -> Point:
    readings_e = np.array([one.reading_g for one in group]) / e_g
    sizes = np.array([one.samples for one in group])
    sigmas_e = np.array([one.sigma_g for one in group]) / e_g
    raw_e = np.array([one.raw_sigma_g for one in group]) / e_g
    errors_e = readings_e - load_g / e_g
    up, down = (
        np.array([one.reading_g / e_g for one in group if one.direction == way])
        for way in ("up", "down")
    )
    limit_e = float(permitted_error_e(load_g / e_g))
    worst_e = float(np.abs(errors_e).max())
    return Point(
        load_g=load_g,
        is_known=is_known,
        placements=len(group),
        samples=int(sizes.sum()),
        mean_error_e=float(errors_e.mean()) if is_known else None,
        worst_error_e=worst_e if is_known else None,
        sigma_e=float(np.sqrt((sigmas_e**2 * (sizes - 1)).sum() / (sizes - 1).sum())),
        repeatability_e=float(np.ptp(readings_e)),
        hysteresis_e=float(down.mean() - up.mean()) if len(up) and len(down) else None,
        bound_e=float(np.sqrt(np.nanmean(raw_e**2) / sizes.mean())),
        limit_e=limit_e,
        limit_in_service_e=IN_SERVICE * limit_e,
        within=worst_e <= limit_e if is_known else None,
        within_in_service=worst_e <= IN_SERVICE * limit_e if is_known else None,
    )


def weigh_up(
    recording: Recording,
    analysis: Analysis,
    loads_g: Sequence[float] | None = None,
    e_g: float | None = None,
) -> Weighing:
    """Everything that a capture tells of the scale.

    analysis : with a truth, that tells what lay there.
    loads_g : what lay on it, in any order; None and no truth: nobody knows, so there are no errors.
    e_g : the verification interval; None: as the capture tells it.
    """
    e_g = interval_g(recording) if e_g is None else e_g
    placements = placements_of(recording, analysis)
    if not placements:
        raise UsageError(
            f"{recording.path}: no load lay long enough to be read",
            remedy="Leave each load on the scale for 3 s at least.",
        )
    is_known = loads_g is not None or analysis.truth_g is not None
    if analysis.truth_g is not None:
        loads = [_true_load(analysis, one) for one in placements]
    elif loads_g is not None:
        loads = nearest_loads(placements, loads_g)
        missing = sorted(set(map(float, loads_g)) - set(loads))
        if missing:
            raise UsageError(
                f"{recording.path}: nothing was read near {', '.join(f'{g:g} g' for g in missing)}"
            )
    else:
        loads = _alike(placements, e_g)
    groups: dict[float, list[Placement]] = {}
    for one, load_g in zip(placements, loads, strict=True):
        groups.setdefault(load_g, []).append(one)
    noise_counts = next(counts for most, counts in FLOOR_COUNTS if analysis.rate_hz <= most)
    return Weighing(
        e_g=e_g,
        max_g=max_load_g(recording),
        rate_hz=analysis.rate_hz,
        floor_e=noise_counts * mg_per_count(recording) / units.MG_PER_G / e_g,
        placements=placements,
        points=[_point(load, groups[load], is_known, e_g) for load in sorted(groups)],
    )
