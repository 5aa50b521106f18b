# SPDX-License-Identifier: MIT
"""Dynamic weighing: what the checkweigher says of products on the simulated belt, beside the truth
and beside what common filters make of the same samples.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from terazi.applications.weighing import peers
from terazi.applications.weighing.belt import Belt, Passage, Record, simulate
from terazi.cshared import Checkweigher, CheckweigherEvent, Scale
from terazi.design import scale as design
from terazi.link.generated.messages import Product

E_G = 1.0
RATE_HZ = 80.0
NOISE_COUNTS = 39.0  # 90 nV rms at 80 samples a second and gain 128, HX711 datasheet p. 3
LIMITS_G = (400.0, 600.0, 800.0)  # of four classes
TUNING_SEED_STEP = 1_000_003  # the peers' settings are found on another belt than the judged one
TUNING_PRODUCTS = 240
MATCH_S = 0.15  # from leaving the platform to the verdict's time, at most
ONE_Q7 = 128
UNWEIGHED = 255

# The device's factory settings but for the classes. Both thresholds lie below the lightest product
# and above what the empty platform rings by; ramps last up to 60 ms.
CONFIG = {
    "limit_mg": [*(round(limit * 1000) for limit in LIMITS_G), 0, 0, 0, 0],
    "enter_mg": 100_000,
    "leave_mg": 60_000,
    "settle_us": 65_000,
    "tail_us": 75_000,
    "gap_us": 20_000,
    "classes": len(LIMITS_G) + 1,
    "samples_min": 12,
}


@dataclass(frozen=True)
class Verdict:
    """What a checkweigher said of one product; mass_g is None where it was not weighed."""

    left_s: float
    mass_g: float | None
    class_at: int | None


@dataclass(frozen=True)
class Samples:
    """What the converter gave: (n,) seconds of the record and (n,) gram."""

    time_s: np.ndarray
    mass_g: np.ndarray


@dataclass(frozen=True)
class Part:
    """Products of one range of weights, or of tones, in e."""

    products: int
    mean_error_e: float
    sigma_e: float


@dataclass(frozen=True)
class Dynamic:
    """All figures of one run."""

    throughput_per_min: float
    mean_error_e: float
    sigma_e: float
    right_class_share: float
    per_load: dict[str, Part]
    per_tone: dict[str, Part]
    peers: dict[str, Part]
    peers_per_tone: dict[str, dict[str, Part]]
    settings: dict[str, str]  # of the peers
    errors_e: np.ndarray  # (products,), nan where one was not weighed
    passages: tuple[Passage, ...]
    weighed_by: str

    def plain(self) -> dict:
        """What `terazi weigh dynamic --json` prints."""

        def figures(part: Part) -> dict:
            return {"mean_error_e": part.mean_error_e, "sigma_e": part.sigma_e}

        def counted(parts: dict[str, Part]) -> dict:
            return {name: {"products": p.products, **figures(p)} for name, p in parts.items()}

        return {
            "throughput_per_min": self.throughput_per_min,
            "e_g": E_G,
            "mean_error_e": self.mean_error_e,
            "sigma_e": self.sigma_e,
            "right_class_share": self.right_class_share,
            "per_load": counted(self.per_load),
            "peers": {name: figures(part) for name, part in self.peers.items()},
            "per_tone": {
                name: {
                    "products": part.products,
                    **figures(part),
                    "peers": {n: figures(p) for n, p in self.peers_per_tone[name].items()},
                }
                for name, part in self.per_tone.items()
            },
            "peer_settings": self.settings,
            "weighed_by": self.weighed_by,
        }

    def least_ratio(self) -> float:
        """Sigma of the best peer over ours, in the part of the tones where that is least."""
        return min(
            min(peer.sigma_e for peer in self.peers_per_tone[name].values()) / part.sigma_e
            for name, part in self.per_tone.items()
        )


def convert(record: Record, *, seed: int, rate_hz: float = RATE_HZ) -> tuple[np.ndarray, ...]:
    """The converter on the host: (n,) seconds, (n,) int32 counts of the nominal cell."""
    random = np.random.default_rng((seed, 711))
    first_s = random.uniform(0.0, 1.0) / rate_hz
    time_s = np.arange(first_s, record.duration_s, 1.0 / rate_hz)
    (_, zero_g), (span_counts, span_g) = design.default_points()
    counts = (record.at(time_s) - zero_g) * span_counts / span_g
    counts += random.normal(0.0, NOISE_COUNTS, len(counts))
    return time_s, np.rint(counts).astype(np.int32)


def weigh_on_host(
    record: Record, *, seed: int, rate_hz: float = RATE_HZ, config: Mapping = CONFIG
) -> tuple[list[Verdict], Samples]:
    """The device's C on this machine, fed as the device is."""
    time_s, counts = convert(record, seed=seed, rate_hz=rate_hz)
    masses_mg = Scale().masses(counts * ONE_Q7)
    times_us = np.rint(time_s * 1e6).astype(np.uint32)
    checkweigher, verdicts = Checkweigher(config), []
    for mass_mg, device_us in zip(masses_mg.tolist(), times_us.tolist(), strict=True):
        event = checkweigher.update(mass_mg, device_us)
        left_s = checkweigher.left_us * 1e-6
        if event == CheckweigherEvent.VERDICT:
            verdicts.append(Verdict(left_s, checkweigher.mass_mg * 1e-3, checkweigher.class_at))
        elif event == CheckweigherEvent.UNWEIGHED:
            verdicts.append(Verdict(left_s, None, None))
    return verdicts, Samples(time_s, masses_mg * 1e-3)


def from_device(
    products: Sequence[tuple[int, Product]], samples: Sequence[tuple[int, int]]
) -> tuple[list[Verdict], Samples]:
    """What a device sent, (device_us, PRODUCT) and (device_us, raw counts), as on the host."""
    verdicts = [
        Verdict(left_us * 1e-6, None, None)
        if one.verdict == UNWEIGHED
        else Verdict(left_us * 1e-6, one.mass_mg * 1e-3, one.verdict)
        for left_us, one in products
    ]
    times_us, counts = (np.array(column) for column in zip(*samples, strict=True))
    masses_mg = Scale().masses((counts * ONE_Q7).astype(np.int32))
    return verdicts, Samples(times_us * 1e-6, masses_mg * 1e-3)


def lying(samples: Samples, passages: Sequence[Passage], length: int) -> np.ndarray:
    """(products, length): the last masses of each while it lies wholly on the platform."""
    ends = np.searchsorted(samples.time_s, [passage.off_s for passage in passages])
    return np.stack([samples.mass_g[end - length : end] for end in ends])


def shortest(samples: Samples, passages: Sequence[Passage]) -> int:
    """How many masses every product lies there for."""
    begins = np.searchsorted(samples.time_s, [passage.on_s for passage in passages])
    ends = np.searchsorted(samples.time_s, [passage.off_s for passage in passages])
    return int((ends - begins).min())


def matched(verdicts: Sequence[Verdict], passages: Sequence[Passage]) -> list[Verdict | None]:
    """The one verdict on each product; None where there is none or more than one."""
    found: list[Verdict | None] = []
    for passage in passages:
        near = [each for each in verdicts if abs(each.left_s - passage.leaves_s) < MATCH_S]
        found.append(near[0] if len(near) == 1 else None)
    return found


def tuned_peers(belt: Belt, *, length: int, rate_hz: float) -> dict[str, peers.Peer]:
    """The best setting of each family on another belt of the same kind."""
    other = replace(belt, seed=belt.seed + TUNING_SEED_STEP, products=TUNING_PRODUCTS)
    record = simulate(other)
    time_s, counts = convert(record, seed=other.seed, rate_hz=rate_hz)
    samples = Samples(time_s, Scale().masses(counts * ONE_Q7) * 1e-3)
    masses = lying(samples, record.passages, length)
    weights = np.array([passage.weight_g for passage in record.passages])
    return peers.best(peers.families(length, rate_hz), masses, weights)


def score(
    record: Record,
    verdicts: Sequence[Verdict],
    samples: Samples,
    *,
    weighed_by: str,
    progress: Callable[[str], None] = lambda _: None,
) -> Dynamic:
    """Judge verdicts by the truth, and the common filters by the same samples."""
    passages = record.passages
    rate_hz = 1.0 / float(np.median(np.diff(samples.time_s)))
    weights = np.array([passage.weight_g for passage in passages])
    tones = np.array([passage.tone_hz for passage in passages])
    found = matched(verdicts, passages)
    weighed = [np.nan if one is None or one.mass_g is None else one.mass_g for one in found]
    errors = (np.array(weighed) - weights) / E_G
    true_class = np.searchsorted(LIMITS_G, weights, side="right")
    right = [
        one is not None and one.class_at == at for one, at in zip(found, true_class, strict=True)
    ]
    progress("common filters, at their best setting on other products")
    length = shortest(samples, passages)
    tuned = tuned_peers(record.belt, length=length, rate_hz=rate_hz)
    masses = lying(samples, passages, length)
    peer_errors = {name: (peer.run(masses) - weights) / E_G for name, peer in tuned.items()}
    left_s = [one.left_s for one in verdicts]
    by_tone = _ranges(tones, belt_parts(record.belt), "Hz")
    return Dynamic(
        throughput_per_min=60.0 * (len(left_s) - 1) / (left_s[-1] - left_s[0]),
        mean_error_e=float(np.nanmean(errors)),
        sigma_e=float(np.nanstd(errors)),
        right_class_share=float(np.mean(right)),
        per_load={
            name: _part(errors[chosen])
            for name, chosen in _ranges(weights, _loads(record.belt), "g").items()
        },
        per_tone={name: _part(errors[chosen]) for name, chosen in by_tone.items()},
        peers={name: _part(each) for name, each in peer_errors.items()},
        peers_per_tone={
            part: {name: _part(each[chosen]) for name, each in peer_errors.items()}
            for part, chosen in by_tone.items()
        },
        settings={name: peer.setting for name, peer in tuned.items()},
        errors_e=errors,
        passages=passages,
        weighed_by=weighed_by,
    )


def belt_parts(belt: Belt) -> np.ndarray:
    """Edges of four equal parts, in octaves, of the belt's tones."""
    low, high = belt.tone_hz
    return low * (high / low) ** np.linspace(0, 1, 5)


def _loads(belt: Belt) -> np.ndarray:
    return np.linspace(*belt.weight_g, 5)


def _ranges(values: np.ndarray, edges: np.ndarray, unit: str) -> dict[str, np.ndarray]:
    """(products,) which of them lie in each range that holds any."""
    ranges = {}
    for low, high in itertools.pairwise(edges):
        chosen = (values >= low) & ((values < high) | (high == edges[-1]))
        if chosen.any():
            ranges[f"{low:.4g}..{high:.4g} {unit}"] = chosen
    return ranges


def _part(errors: np.ndarray) -> Part:
    known = errors[~np.isnan(errors)]
    if not len(known):
        return Part(len(errors), float("nan"), float("nan"))
    return Part(len(errors), float(np.mean(known)), float(np.std(known)))
