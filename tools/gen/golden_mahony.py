# SPDX-License-Identifier: MIT
"""Golden vectors of mahony: from its exact twin, and from rotations in closed form."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator

from terazi.design import mahony as design
from terazi.models import exact_mahony
from tools.gen.golden import SEED, Draft

ORIGIN = "terazi.models.exact_mahony, the contracts of the headers in unbounded integers"
LOW, HIGH = -32768, 32767
RATE_HZ = 285.714285714
COLUMNS = (
    {"gap_samples": "missing before this one"}
    | {f"gyro_{axis}_counts": "counts, int16" for axis in "xyz"}
    | {f"acc_{axis}_counts": "counts, int16" for axis in "xyz"}
    | {f"mag_{axis}_counts": "counts, int16; without meaning for 6 axes" for axis in "xyz"}
    | {f"bias_{axis}_q16": "counts, Q16 in int32" for axis in "xyz"}
    | {f"quat_{part}_q30": "body to world, Q30 in int32" for part in "wxyz"}
    | {f"{angle}_q13": "rad, Q13 in int16" for angle in ("roll", "pitch", "yaw")}
)
Sample = tuple[int, tuple, tuple, tuple, tuple]  # gap, gyro, acc, mag, bias
FIELD = (0, 2000, -4500)
NO_BIAS = (0, 0, 0)


def clipped(values) -> tuple[int, ...]:
    """To int16."""
    return tuple(min(HIGH, max(LOW, round(value))) for value in values)


def at_rest(rng: random.Random, count: int, up=(0, 0, 2048), field=FIELD) -> list[Sample]:
    """A board that lies still, in sensor noise, its gyroscope off by a little."""
    bias = (700_000, -300_001, 65_535)
    return [
        (
            0,
            clipped(rng.gauss(b / 65536, 1.5) for b in bias),
            clipped(rng.gauss(value, 4.0) for value in up),
            clipped(rng.gauss(value, 20.0) for value in field),
            bias,
        )
        for _ in range(count)
    ]


def swung(count: int) -> list[Sample]:
    """A board that is swung about all axes, up to 1500 deg/s and 4 g."""
    samples = []
    for n in range(count):
        phase = n / 9
        swing, wave = math.sin(phase), math.cos(phase)
        gyro = (24_000 * swing, 9_000 * math.cos(2 * phase), -15_000 * math.sin(phase / 3))
        acc = (6_000 * math.sin(phase / 2), 3_000 * wave, 2_048 + 5_000 * swing)
        mag = (2_000 * swing, 2_000 * wave, -4_500)
        samples.append((0, clipped(gyro), clipped(acc), clipped(mag), NO_BIAS))
    return samples


def bad(rng: random.Random, count: int) -> list[Sample]:
    """Rails, zeros, gaps short and long, noise of full scale."""

    def vector(spread: int) -> tuple[int, ...]:
        return tuple(rng.randint(-spread, spread) for _ in range(3))

    samples = []
    for n in range(count):
        gyro, acc, mag = vector(32_000), vector(30_000), vector(9_000)
        if n % 5 == 1:
            gyro = tuple(rng.choice((LOW, HIGH)) for _ in range(3))
        if n % 7 == 2:
            acc = tuple(rng.choice((LOW, HIGH, 0)) for _ in range(3))
        if n % 11 == 3:
            acc = (0, 0, 0)
        if n % 6 == 4:
            mag = rng.choice(((0, 0, 0), (LOW, LOW, LOW), (0, 0, 1), (HIGH, 0, LOW)))
        gap = {30: 3, 70: 29, 71: 1000, 110: 65_535}.get(n, 0)
        samples.append((gap, gyro, acc, mag, vector(1 << 25)))
    return samples


def moved_to_another_field(count: int, rate_hz: float) -> list[Sample]:
    """A level board that turns at 40 deg/s; after a quarter of the time the field is another."""
    rate, samples = 655, []
    for n in range(count):
        angle = n * math.radians(rate / 16.384) / rate_hz
        north, up = (2000, -4500) if 4 * n < count else (2900, -3000)
        mag = clipped((north * math.sin(angle), north * math.cos(angle), up))
        samples.append((0, (0, 0, rate), (0, 0, 2048), mag, NO_BIAS))
    return samples


def pitching(count: int) -> list[Sample]:
    """Nose up through the vertical, slowly, then down through it: angles at their lock."""
    rate = 700
    samples = [(0, (0, 0, 0), (0, 0, 2048), FIELD, NO_BIAS)]
    angle_per_sample = math.radians(rate / 16.384) / 285.714285714
    for n in range(count):
        angle = n * angle_per_sample
        acc = (2048 * math.sin(angle), 0, 2048 * math.cos(angle))
        samples.append((0, (0, -rate, 0), clipped(acc), FIELD, NO_BIAS))
    return samples


def cases() -> dict[str, tuple[str, int, dict, list[Sample]]]:
    """name -> (what it shows, axes, configuration, samples)."""
    rng = random.Random(SEED + 30)
    usual = design.named("286hz")
    fast = design.config_at(RATE_HZ, ramp_s=0.1)  # a start of 6 samples
    broken = bad(rng, 160)
    linear, classic = (design.config_at(RATE_HZ, mode, ramp_s=0.1) for mode in design.MODES[1:])
    calm = design.config_at(RATE_HZ, ramp_s=0.25)  # of 24
    with_ki = design.config_at(RATE_HZ, ki_rad_s2=0.01, ramp_s=0.1)
    slow, quick = design.config_at(100.0, ramp_s=0.1), design.config_at(1000.0, ramp_s=0.05)
    moved = moved_to_another_field(320, 100.0)
    tilted, turned_over = (500, -900, 1770), (60, -40, -2048)
    short = design.config_at(100.0, ramp_s=0.1, recover_s=0.05, accept_s=0.1, reject_s=0.2)
    magnet = at_rest(rng, 80) + at_rest(rng, 60, field=(3000, 2500, -4000)) + at_rest(rng, 60)
    return {
        "rest": ("at rest, tilted: start, ramp, carries", 6, calm, at_rest(rng, 150, tilted)),
        "upside_down": ("start on its back", 6, usual, at_rest(rng, 150, turned_over)),
        "fast": ("swung up to 1500 deg/s and 4 g", 6, fast, at_rest(rng, 3) + swung(240)),
        "slow_rate": ("100 Hz: three steps a sample", 6, slow, swung(100)),
        "linear": ("not averaged, not normalised", 6, linear, swung(100)),
        "classic": ("classic: normalised, ki", 6, classic, swung(100)),
        "integral": ("second order with ki, on rails", 6, with_ki, swung(60) + broken[:60]),
        "bad": ("rails, zeros and gaps, 6 axes", 6, fast, broken),
        "bad_field": ("rails, zeros and gaps, 9 axes", 9, fast, broken),
        "pitch": ("Euler angles through 90 deg of pitch, upwards", 6, usual, pitching(620)),
        "heading": ("heading from the field, 1 kHz", 9, quick, swung(150)),
        "new_field": ("another field that stays while the board turns", 9, short, moved),
        "magnet": ("a magnet comes, is bridged, stays too long, goes", 9, short, magnet),
    }


def twin_rows(config: dict, axes: int, samples: list[Sample]):
    """Rows and counts of the exact twin."""
    twin, held, rows = exact_mahony.Mahony(config), [0, 0], []
    for gap, gyro, acc, mag, bias in samples:
        if gap:
            twin.gap(gap)
        twin.update(gyro, acc, bias)
        if axes == 9:
            twin.update_mag(mag)
        rows.append((gap, *gyro, *acc, *mag, *bias, *twin.quaternion(), *twin.euler(held)))
    return rows, twin.counts


def closed_form() -> Draft:
    """A level board that stands, is then turned about the vertical at a constant rate, past a
    quarter turn."""
    config = design.named("286hz")
    start = exact_mahony.START_LEN * (config["ramp_mask"] + 1)
    rows = []
    for n in range(start + 300):
        rate = 1638 if n >= start else 0
        half = max(0, n + 1 - start) * rate * config["gyro_q33"] / 2**33
        quat = [round(2**30 * part) for part in (math.cos(half), 0, 0, math.sin(half))]
        yaw = round(8192 * math.remainder(2 * half, 2 * math.pi))
        rows.append((0, 0, 0, rate, 0, 0, 2048, 0, 0, 0, 0, 0, 0, *quat, 0, 0, yaw))
    return Draft(
        "mahony_published_turn",
        "mahony: a turn about the vertical, past 90 deg, is the rotation in closed form",
        dict(COLUMNS),
        rows,
        kind="published",
        origin="Euler's formula: q = (cos a/2, 0, 0, sin a/2), yaw a",
        parameters={**_words(config), "axes": "6", "tolerance_q30": "32768", "tolerance_q13": "2"},
    )


def _words(config: dict) -> dict[str, str]:
    return {field: str(value) for field, value in config.items()}


def drafts() -> Iterator[Draft]:
    """All vectors of mahony."""
    yield closed_form()
    for name, (shows, axes, config, samples) in cases().items():
        rows, counts = twin_rows(config, axes, samples)
        yield Draft(
            f"mahony_{name}",
            f"mahony: {shows}",
            dict(COLUMNS),
            rows,
            origin=ORIGIN,
            seed=str(SEED + 30),
            parameters={
                **_words(config),
                "axes": str(axes),
                **{f"counted_{key}": str(value) for key, value in counts.items()},
            },
        )
