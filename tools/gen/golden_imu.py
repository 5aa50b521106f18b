# SPDX-License-Identifier: MIT
"""Golden vectors of imu_cal and rest, from their exact twins."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator

from terazi.design import rest as rest_design
from terazi.models import exact_imu
from tools.gen.golden import SEED, Draft

LOW, HIGH = exact_imu.INT16_MIN, exact_imu.INT16_MAX
ORIGIN = "terazi.models.exact_imu, the contract of the header in unbounded integers"
INT16 = "counts, int16"
AXES = "xyz"
REST_CORNERS = {  # every field at a bound of rest.h
    "enter_acc_counts": 16383,
    "leave_acc_counts": 16383,
    "enter_gyro_counts": 1000,
    "leave_gyro_counts": 1046,
    "bias_max_counts": 1000,
    "lowpass_q16": 32767,
    "still_rounds": 1,
    "gain_len": 2,
    "gravity2_min": 0,
    "gravity2_max": (1 << 16) - 1,
}


def _vector(rng: random.Random, spread: int) -> tuple[int, ...]:
    return tuple(rng.randint(-spread, spread) for _ in AXES)


def _words(values) -> str:
    return " ".join(str(value) for value in values)


CORNERS = [(0, 0, 0), (1, -1, 2048), (LOW, LOW, LOW), (HIGH, HIGH, HIGH), (LOW, HIGH, LOW)]


def imu_cal_drafts() -> Iterator[Draft]:
    """Identity, a usual board, one at the bounds of imu_cal.h."""
    rng = random.Random(SEED + 20)
    usual = ([[1966, -655, 300], [41, -3277, 1311], [-20, 999, 77]], [24, -151, 3])
    bounds = ([[32767, 0, 0], [-10923, 10922, -10922], [0, 0, -32767]], [HIGH, LOW, 0])
    cases = {
        "identity": ("without constants every value is passed on", ([[0] * 3] * 3, [0] * 3)),
        "usual": ("scale, cross-axes and offsets of a usual board", usual),
        "bounds": ("constants at the bounds: sums of 32 bits, results that saturate", bounds),
    }
    for name, (shows, (matrix, offset)) in cases.items():
        raws = CORNERS + [_vector(rng, spread) for spread in (40, 2048, 32767) for _ in range(20)]
        results, clipped = exact_imu.imu_cal(raws, matrix, offset)
        yield Draft(
            f"imu_cal_apply_{name}",
            f"imu_cal: {shows}",
            {f"raw_{axis}_counts": INT16 for axis in AXES}
            | {f"true_{axis}_counts": INT16 for axis in AXES},
            [(*r, *t) for r, t in zip(raws, results, strict=True)],
            origin=ORIGIN,
            seed=str(SEED + 20),
            parameters={
                "matrix_q16": _words(value for row in matrix for value in row),
                "offset_q3": _words(offset),
                "clipped": str(clipped),
            },
        )


def imu_cal_temperature_drafts() -> Iterator[Draft]:
    """Offsets of a sensor that warms, up to their limits."""
    rng = random.Random(SEED + 22)
    offset, slope = [24, -32000, 32000], [501, -16384, 16384]
    warmths = [0, 1, -1, 340, LOW, HIGH] + [rng.randint(LOW, HIGH) for _ in range(30)]
    yield Draft(
        "imu_cal_temperature",
        "imu_cal: offsets follow the temperature, half up, up to their limits",
        {"above_reference_counts": "temperature, counts, int16"}
        | {f"offset_{axis}_q3": "counts, Q3 in int16" for axis in AXES},
        [(w, *exact_imu.offset_at_temperature(offset, slope, w)) for w in warmths],
        origin=ORIGIN,
        seed=str(SEED + 22),
        parameters={"offset_q3": _words(offset), "slope_q16": _words(slope)},
    )


def imu_cal_turn_drafts() -> Iterator[Draft]:
    """All orientations that a part can have on a board."""
    rng = random.Random(SEED + 23)
    rows = []
    for orientation in range(64):
        for vector in [(1, 2, 3), *CORNERS[1:], _vector(rng, 32767)]:
            try:
                rows.append((orientation, *vector, *exact_imu.imu_cal_turn(orientation, vector)))
            except ValueError:  # none of the 24
                break
    yield Draft(
        "imu_cal_turn",
        "imu_cal: each of the 24 orientations, limited at the rail",
        {"orientation": "code of imu_cal.h"}
        | {f"part_{axis}_counts": INT16 for axis in AXES}
        | {f"board_{axis}_counts": INT16 for axis in AXES},
        rows,
        origin=ORIGIN,
        seed=str(SEED + 23),
    )


def _lying(rng: random.Random, count: int, bias, gravity: int = 2048):
    """Samples of a board at rest, noise of a few counts."""
    return [
        (
            tuple(round(rng.gauss(b, 1.5)) for b in bias),
            tuple(round(rng.gauss(a, 4.0)) for a in (0, 0, gravity)),
        )
        for _ in range(count)
    ]


def _turned(count: int):
    """Samples of a board that is swung."""
    swing = [round(3000 * math.sin(n / 5)) for n in range(count)]
    return [((v, v // 3, -v // 2), (v // 4, 2048 - abs(v) // 8, v // 6)) for v in swing]


def rest_signals(rng: random.Random) -> dict[str, tuple[str, list]]:
    """name -> (what it shows, samples) for a board at 100 Hz."""
    lying = _lying(rng, 500, (14, -9, 3))
    warmer = _lying(rng, 480, (17, -9, 1))
    rails = _lying(rng, 600, (5, 5, 5))
    for at, rail in {200: HIGH, 201: HIGH, 294: LOW, 295: HIGH}.items():
        gyro, acc = (list(each) for each in rails[at])
        (acc, gyro)[at % 6 // 3][at % 3] = rail  # the axis that is visited then
        rails[at] = (tuple(gyro), tuple(acc))
    dead = _lying(rng, 300, (0, 0, 0), gravity=0)
    drifting = [((22, 0, 31 if n < 200 else 34), (0, 0, 2048)) for n in range(400)]
    own, bias = random.Random(SEED + 24), (20, -20, 8)
    starts = _lying(own, 90, bias) + _turned(12)  # broken off in its first block
    starts += _lying(own, 140, bias) + _turned(12) + _lying(own, 170, bias)
    return {
        "learns": ("bias learnt, motion, bias followed", lying + _turned(60) + warmer),
        "rails": ("samples on a rail are no rest, and counted", rails),
        "dead": ("an accelerometer that feels nothing: no block is learnt", dead),
        "turns": ("a constant rate, below what a bias may be, then beyond it", drifting),
        "starts": ("an eighth of the stillness, until a block is learnt; then all of it", starts),
    }


def rest_drafts() -> Iterator[Draft]:
    """A board at 100 Hz, and a configuration at the bounds of rest.h on noise of full scale."""
    rng = random.Random(SEED + 21)
    usual = rest_design.config_at(100.0)
    cases = {name: (*case, usual) for name, case in rest_signals(rng).items()}
    noise = [(_vector(rng, 500), _vector(rng, 8000)) for _ in range(300)]
    noise += [(_vector(rng, 700), _vector(rng, 32767)) for _ in range(100)]
    cases["corners"] = ("configuration at its bounds, on noise", noise, REST_CORNERS)
    for name, (shows, samples, config) in cases.items():
        twin = exact_imu.Rest(config)
        rows = []
        for gyro, acc in samples:
            flags = twin.update(gyro, acc)
            rows.append((*gyro, *acc, flags, *twin.bias_q16))
        yield Draft(
            f"rest_{name}",
            f"rest: {shows}",
            {f"gyro_{axis}_counts": INT16 for axis in AXES}
            | {f"acc_{axis}_counts": INT16 for axis in AXES}
            | {"flags": "bits: 1 at rest, 2 bias known"}
            | {f"bias_{axis}_q16": "counts, Q16 in int32" for axis in AXES},
            rows,
            origin=ORIGIN,
            seed=str(SEED + 21),
            parameters={
                **{field: str(value) for field, value in config.items()},
                "rejected": str(twin.rejected),
                "implausible": str(twin.implausible),
            },
        )


def drafts() -> list[Draft]:
    """All of both."""
    return [
        *imu_cal_drafts(),
        *imu_cal_temperature_drafts(),
        *imu_cal_turn_drafts(),
        *rest_drafts(),
    ]
