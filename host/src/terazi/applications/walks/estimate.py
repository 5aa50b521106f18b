# SPDX-License-Identifier: MIT
"""From a walk to its path: a detector, a navigator, and what is switched on besides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import inf
from pathlib import Path as Weights

from terazi.applications.walks import detectors as of
from terazi.applications.walks.checks import check_standing, stride_note
from terazi.applications.walks.clipping import clipping_note
from terazi.applications.walks.complementary import ComplementarySettings, complementary
from terazi.applications.walks.detectors import Detection
from terazi.applications.walks.elimination import eliminate
from terazi.applications.walks.navigator import (
    KalmanSettings,
    Path,
    kalman,
    rolled,
)
from terazi.applications.walks.networks import SHIPPED, load_network
from terazi.applications.walks.record import Walk
from terazi.applications.walks.steps import Strides, find_strides
from terazi.errors import UsageError

DETECTORS = {
    "moving_variance": (of.moving_variance_detector, of.MOVING_VARIANCE, of.MOVING_VARIANCE),
    "magnitude": (of.magnitude_detector, of.MAGNITUDE, of.MAGNITUDE),
    "rate_energy": (of.rate_energy_detector, of.RATE_ENERGY, of.RATE_ENERGY),
    "shoe": (of.shoe_detector, of.SHOE, of.SHOE),
    "adaptive_shoe": (of.adaptive_shoe_detector, of.ADAPTIVE_BATCH, of.ADAPTIVE_CAUSAL),
    "low_pass": (of.low_pass_detector, of.LOW_PASS, of.LOW_PASS),
}
"""Each with its settings for a recorded walk and for a causal run."""
LEARNT, DEVICE = "learnt", "device"
ROLL_SHARE = 0.012
"""By this share of its length each stride is longer than zero velocity makes it: in a stance the
foot rolls ahead, by a centimetre or two. Found alike on optical truth (1.4 %) and on footprints
measured with a ruler (1.3 %), other people with other sensors."""
ALL_DETECTORS = (*DETECTORS, LEARNT, DEVICE)
NAVIGATORS = ("kalman", "complementary")


@dataclass(frozen=True)
class Options:
    """What is run; one setting for all walks."""

    detector: str = "adaptive_shoe"
    navigator: str = "kalman"
    causal: bool = False
    threshold: float | None = None  # another than the detector's own
    weights: Weights | None = None  # of the learnt detector; None: those that are shipped
    roll_share: float = ROLL_SHARE
    eliminate_drift: bool = False  # heuristically; recorded walks only
    kalman: KalmanSettings | None = None  # None: as they are shipped
    complementary: ComplementarySettings = field(default_factory=ComplementarySettings)


@dataclass(frozen=True)
class Result:
    """A walk, where it stood, its path and strides."""

    walk: Walk
    detection: Detection
    path: Path
    strides: Strides


def detect(walk: Walk, options: Options) -> Detection:
    """When the foot stands still: as it is known in the end, and as it was at once."""
    named = options.detector
    if named == DEVICE and walk.device is not None:
        named = f"{named} ({walk.device.detector})"
    detection, at_once = _detect(walk, options)
    at_once = replace(at_once, detector=named)
    return replace(detection, detector=named, at_once=at_once)


def _detect(walk: Walk, options: Options) -> tuple[Detection, Detection]:
    if options.detector == DEVICE:
        if options.threshold is not None:
            raise UsageError("--threshold changes nothing of what a device has decided")
        return of.device_detector(walk, causal=False), of.device_detector(walk, causal=True)
    if options.detector == LEARNT:
        network = load_network(options.weights or SHIPPED)
        return of.learnt_detectors(walk, network, least_doubt=options.threshold)
    if options.detector not in DETECTORS:
        raise ValueError(f"no detector {options.detector!r}; there are {', '.join(ALL_DETECTORS)}")
    run, *both = DETECTORS[options.detector]
    if options.threshold is not None:
        name = "low_rad_s" if options.detector == "adaptive_shoe" else "threshold"
        both = [replace(settings, **{name: options.threshold}) for settings in both]
    batch, causal = both
    return run(walk, batch, causal=False), run(walk, causal, causal=True)


def estimate(
    walk: Walk, options: Options | None = None, *, progress: Callable[[float], None] | None = None
) -> Result:
    """The path. Raises CannotRead where the sensor never stands still."""
    options = options or Options()
    if options.eliminate_drift and options.causal:
        raise UsageError("drift elimination looks at the whole path: it cannot run causally")
    if options.navigator not in NAVIGATORS:
        raise ValueError(f"no navigator {options.navigator!r}; there are {', '.join(NAVIGATORS)}")
    detection = detect(walk, options)
    shown = detection.at_once if options.causal else detection
    walk = check_standing(walk, shown.still)
    path = _navigated(walk, detection, options, progress)
    strides = find_strides(path, walk.rate_hz)
    notes = (*clipping_note(walk.rates), *stride_note(strides_s(walk, strides)))
    if options.eliminate_drift:
        # It looks at the whole path anyway: at the one that nothing holds back.
        free = _navigated(walk, detection, _freed(options), None)
        done = eliminate(free, find_strides(free, walk.rate_hz), walk.t_s)
        if done.applied:
            path, strides = done.path, find_strides(done.path, walk.rate_hz)
        words = "applied" if done.applied else "left off"
        notes = (*notes, f"drift elimination {words}: {done.words}")
    return Result(replace(walk, notes=(*walk.notes, *notes)), shown, path, strides)


def _navigated(walk: Walk, detection: Detection, options: Options, progress) -> Path:
    if options.navigator == "kalman":
        settings = options.kalman or KalmanSettings()
        path = kalman(walk, detection, settings, causal=options.causal, progress=progress)
    else:
        path = complementary(walk, detection, options.complementary, causal=options.causal)
    return rolled(path, options.roll_share)


def _freed(options: Options) -> Options:
    return replace(
        options,
        kalman=replace(options.kalman or KalmanSettings(), held_m=inf),
        complementary=replace(options.complementary, held_m=inf),
    )


def strides_s(walk: Walk, strides: Strides):
    """How long each stride lasts, rests included."""
    return walk.t_s[strides.at[1:]] - walk.t_s[strides.at[:-1]]
