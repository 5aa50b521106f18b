# SPDX-License-Identifier: MIT
"""Writes shared_c/vectors: golden vectors from published figures and from the exact twins.

Not one number here comes from the C that the vectors judge.
"""

from __future__ import annotations

import hashlib
import platform
import random
import subprocess
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from terazi.design import specs
from terazi.models import (
    exact,
    exact_checkweigher,
    exact_faults,
    exact_imu,
    exact_scale,
    exact_temperature,
    exact_weight_kf_adaptive,
    exact_zupt,
    exact_zupt_gru,
    settings,
)
from tools.gen.spec import ROOT

FOLDER = ROOT / "shared_c" / "vectors"
SEED = 20_251_122
TWINS = (exact, exact_checkweigher, exact_faults, exact_imu, exact_scale, exact_temperature)
TWINS += (exact_weight_kf_adaptive, exact_zupt, exact_zupt_gru, settings, specs)
RAIL_LOW, RAIL_HIGH = exact.COUNTS_MIN, exact.COUNTS_MAX

COUNTS = "counts, 24 bits in int32"
ANY_COUNTS = "counts, int32, also beyond 24 bits"
COUNTS_Q7 = "counts, Q7 in int32"


@dataclass
class Draft:
    """A vector about to be written."""

    name: str
    claim: str
    columns: dict[str, str]  # name -> unit and format
    rows: list[tuple]
    kind: str = "model"
    origin: str = "terazi.models.exact, the contract of the header in unbounded integers"
    seed: str = "none"
    parameters: dict[str, str] = field(default_factory=dict)


def generator_mark() -> str:
    """Which code made the vectors: a hash of it, and the commit it stood on."""
    digest = hashlib.sha256()
    twins = [Path(module.__file__) for module in TWINS]
    for path in (*sorted(Path(__file__).parent.glob("golden*.py")), *twins):
        digest.update(path.read_bytes())
    head = subprocess.run(
        ["git", "rev-parse", "--short=8", "HEAD"], cwd=ROOT, capture_output=True, text=True
    )
    commit = head.stdout.strip() or "unknown"
    return f"tools/gen/golden.py, sha256 {digest.hexdigest()[:16]}, on commit {commit}"


def text_of(draft: Draft, mark: str) -> str:
    """A vector file's text; terazi.models.vectors reads it."""
    lines = [
        f"# claim: {draft.claim}",
        f"# kind: {draft.kind}",
        f"# origin: {draft.origin}",
        f"# generator: {mark}",
        f"# libraries: python {platform.python_version()}, numpy {np.__version__}",
        f"# seed: {draft.seed}",
    ]
    lines += [f"# parameter {name}: {value}" for name, value in draft.parameters.items()]
    lines += [f"# column {name}: {unit}" for name, unit in draft.columns.items()]
    lines.append(",".join(draft.columns))
    for row in draft.rows:
        cells = (cell.hex() if isinstance(cell, bytes) else str(cell) for cell in row)
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


def signals(rng: random.Random) -> dict[str, tuple[str, int, list[int]]]:
    """name -> (what it shows, first value, samples) for filters of counts."""
    impulse = [0] * 4 + [RAIL_HIGH] + [0] * 36
    steps = [-1_000_000] * 3 + [4_194_304] * 40 + [4_194_303] * 5 + [-77_777] * 40
    rails = [RAIL_LOW, RAIL_HIGH] * 4 + [RAIL_LOW] * 40 + [RAIL_HIGH] * 40
    rails += [exact.INT32_MIN, exact.INT32_MAX, RAIL_LOW - 1, RAIL_HIGH + 1] * 3
    full = [rng.randint(RAIL_LOW, RAIL_HIGH) for _ in range(120)]
    weight = [429_550 + sum(rng.randint(-33, 33) for _ in range(4)) for _ in range(120)]  # 38.7 rms
    weight[60:] = [value + 214_775 for value in weight[60:]]
    return {
        "impulse": ("an impulse of full scale", 0, impulse),
        "steps": ("steps up, by one count, and down", -1_000_000, steps),
        "rails": ("both rails, and samples beyond them, which are clamped and counted", 0, rails),
        "random": ("uniform noise of full scale", RAIL_HIGH, full),
        "weight": ("1 kg in converter noise, then 500 g more", weight[0], weight),
    }


def fir_drafts() -> Iterator[Draft]:
    """FIR designs against their twin."""
    for index, design in enumerate(specs.fir_designs()):
        taps = specs.fir_taps_q15(index).tolist()
        for name, (shows, first, samples) in signals(random.Random(SEED)).items():
            results, clipped = exact.fir(samples, taps, first)
            yield Draft(
                f"fir_{design['name']}_{name}",
                f"fir, design {design['name']}: {shows}",
                {"sample_counts": ANY_COUNTS, "result_counts": COUNTS},
                list(zip(samples, results, strict=True)),
                seed=str(SEED),
                parameters={
                    "design": f"{index} ({design['name']})",
                    "first_counts": str(first),
                    "clipped": str(clipped),
                },
            )


# Loaded from settings: a notch whose neighbours pull hard, odd, and the least there is.
LOADED = {
    "odd7": [-3000, 4096, 9000, 12576, 9000, 4096, -3000],
    "least2": [16384, 16384],
}


def fir_loaded_drafts() -> Iterator[Draft]:
    """Coefficients in RAM against the twin."""
    for design, taps in LOADED.items():
        for name, (shows, first, samples) in signals(random.Random(SEED + 5)).items():
            results, clipped = exact.fir(samples, taps, first)
            yield Draft(
                f"fir_loaded_{design}_{name}",
                f"fir, coefficients {design} loaded into RAM: {shows}",
                {"sample_counts": ANY_COUNTS, "result_counts": COUNTS},
                list(zip(samples, results, strict=True)),
                seed=str(SEED + 5),
                parameters={
                    "taps_q15": " ".join(map(str, taps)),
                    "first_counts": str(first),
                    "clipped": str(clipped),
                },
            )


def weight_kf_drafts() -> Iterator[Draft]:
    """Gain schedules against their twin, and the published step table."""
    for index, schedule in enumerate(specs.weight_kf_schedules()):
        gains = specs.weight_kf_gains_q15(index)
        for name, (shows, first, measured) in signals(random.Random(SEED + 1)).items():
            estimates, clipped = exact.weight_kf(measured, gains, first)
            yield Draft(
                f"weight_kf_{schedule['name']}_{name}",
                f"weight_kf, schedule {schedule['name']}: {shows}",
                {"measured_counts": ANY_COUNTS, "estimate_counts_q7": COUNTS_Q7},
                list(zip(measured, estimates, strict=True)),
                seed=str(SEED + 1),
                parameters={
                    "schedule": f"{index} ({schedule['name']})",
                    "first_counts": str(first),
                    "clipped": str(clipped),
                },
            )
    table = [("157", "157"), ("145", "151"), ("154", "152"), ("160", "154"), ("156", "154.4")]
    yield Draft(
        "weight_kf_published_table3",
        "weight_kf, schedule average: the weighing thesis's step table",
        {
            "measured_counts": "counts (the table's gram)",
            "estimate_counts_q7": "counts, Q7, the printed figure to the nearest 1/128",
        },
        [(int(z), round(float(x) * 128)) for z, x in table],
        kind="published",
        origin="weighing thesis, Table 3: x0 = 150, K = 1, 1/2, 1/3, 1/4, 1/5",
        parameters={"schedule": "1 (average)", "first_counts": "150", "clipped": "0"},
    )


def mass_drafts() -> Iterator[Draft]:
    """Corners, ties and random pairs."""
    rng = random.Random(SEED + 2)
    span_default = 2328 << 16
    nets = [0, 1, -1, 127, 128, -128, exact.INT32_MIN, exact.INT32_MAX, 429_550 * 128]
    spans = [0, 1, span_default, (1 << 32) - 1, 1 << 16, 500 << 16]
    pairs = [(net, span) for net in nets for span in spans]
    # A net of one count at 500 ug, 1500 ug ... a count lies just between two milligrams.
    pairs += [(sign * 128, (500 + 1000 * n) << 16) for n in range(6) for sign in (1, -1)]
    pairs += [(sign * 128, ((500 + 1000 * n) << 16) - 1) for n in range(3) for sign in (1, -1)]
    for _ in range(80):
        net = rng.randint(exact.INT32_MIN, exact.INT32_MAX) >> rng.randrange(24)
        pairs.append((net, rng.getrandbits(32) >> rng.randrange(12)))
    yield Draft(
        "mass_exact",
        "mass: exact, rounded half up to a milligram, saturated to 32 bits",
        {
            "net_counts_q7": COUNTS_Q7,
            "span_ug_per_count_q16": "ug/count, Q16 in uint32",
            "mass_mg": "mg, int32",
        },
        [(net, span, exact.mass_mg(net, span)) for net, span in pairs],
        seed=str(SEED + 2),
    )


def payloads(rng: random.Random) -> list[bytes]:
    """Payloads of all lengths that matter, with and without zeros."""
    chosen = [b"", b"\0", b"\1", bytes(48), b"\xff" * 48, bytes(range(48)), b"\0\1\0\2" * 5]
    chosen += [
        bytes(rng.choice((0, rng.randrange(256))) for _ in range(n)) for n in (1, 19, 37, 47)
    ]
    return chosen


def random_frame(rng: random.Random, payload: bytes) -> tuple[int, int, int, bytes]:
    """id, sequence and clock around a payload."""
    clock = rng.getrandbits(32) & rng.choice((0xFFFFFFFF, 0xFF0000FF, 0))
    return rng.randrange(256), rng.randrange(256), clock, payload


STATUS_CODES = {"pending": 0, "ready": 1, "bad_cobs": 2, "bad_len": 3, "bad_crc": 4}


def decoder_row(stream: bytes) -> tuple[bytes, bytes, bytes]:
    """Stream, the decoder's status after each byte, and the last good body."""
    said = exact.frame_bodies(stream)
    statuses, verdicts = bytearray(), iter(said)
    for byte in stream:
        ends_piece = byte == 0 and statuses and stream[len(statuses) - 1] != 0
        statuses.append(STATUS_CODES[next(verdicts)[0]] if ends_piece else 0)
    good = [body for status, body in said if status == "ready"]
    return stream, bytes(statuses), good[-1]


def broken_streams(rng: random.Random) -> Iterable[bytes]:
    """Streams with every kind of fault, each ending in a good frame."""
    good = exact.frame_encode(*random_frame(rng, b"good"))
    long_body = bytes(rng.randrange(1, 256) for _ in range(57))
    crc = exact.crc16_mcrf4xx(long_body).to_bytes(2, "little")
    yield good
    yield b"\0\0\0" + good + b"\0" + good  # idle line
    yield good[1:] + good  # the first code byte lost
    yield good[:-1] + good + good  # the delimiter lost: two frames run together
    yield good[:5] + b"\0" + good  # cut short
    yield b"\x01\x01\x01\0" + good  # COBS right, too short for a frame
    yield b"\x09" + bytes(range(1, 9)) + b"\0" + good  # shortest length, CRC wrong
    yield exact.cobs_encode(long_body + crc) + b"\0" + good  # CRC right, body too long
    yield b"\xff" * 100 + b"\0" + good  # the longest code byte, which ends no zero
    for at in range(len(good) - 1):
        spoilt = bytearray(good)
        spoilt[at] ^= 1 << rng.randrange(8)
        yield bytes(spoilt) + b"\0" + good
    for _ in range(12):
        yield bytes(rng.choice((0, 1, 2, 5, rng.randrange(256))) for _ in range(90)) + b"\0" + good


def frame_drafts() -> Iterator[Draft]:
    """CRC and COBS from their papers; encoder and decoder against their twins."""
    yield Draft(
        "frame_published_crc",
        "frame: CRC-16/MCRF4XX, check value",
        {"data_hex": "bytes", "crc": "uint16"},
        [(b"123456789", 0x6F91)],
        kind="published",
        origin="catalogue of parametrised CRC algorithms, CRC-16/MCRF4XX: check=0x6f91",
    )
    yield Draft(
        "frame_published_cobs",
        "frame: COBS of an example packet",
        {"body_hex": "bytes before coding", "coded_hex": "bytes on the wire, no delimiter"},
        [
            (
                bytes.fromhex("4500002c4c79000040064f37"),
                bytes.fromhex("024501042c4c79010540064f37"),
            )
        ],
        kind="published",
        origin="Cheshire and Baker 1999, Consistent Overhead Byte Stuffing, the example packet",
    )
    rng = random.Random(SEED + 3)
    frames = [random_frame(rng, payload) for payload in payloads(rng)]
    yield Draft(
        "frame_encode",
        "frame: bytes on the wire of a frame, delimiter included",
        {
            "id": "uint8",
            "sequence": "uint8",
            "device_us": "us, uint32",
            "payload_hex": "bytes",
            "wire_hex": "bytes",
        },
        [(*frame, exact.frame_encode(*frame)) for frame in frames],
        seed=str(SEED + 3),
    )
    rng = random.Random(SEED + 4)
    yield Draft(
        "frame_decode",
        "frame: what the decoder says after each byte of a spoilt stream, and the last good body",
        {
            "wire_hex": "bytes fed to a fresh decoder",
            "status_hex": "frame_status_t after each of them, one byte each",
            "body_hex": "id, sequence, device_us and payload of the last good frame",
        },
        [decoder_row(stream) for stream in broken_streams(rng)],
        seed=str(SEED + 4),
        parameters={f"status_{name}": str(code) for name, code in STATUS_CODES.items()},
    )


def drafts() -> list[Draft]:
    """All golden vectors."""
    # These take Draft from here.
    from tools.gen import (
        golden_adaptive,
        golden_checkweigher,
        golden_faults,
        golden_imu,
        golden_mahony,
        golden_scale,
        golden_settings,
        golden_temperature,
        golden_zupt,
        golden_zupt_gru,
    )

    return [
        *fir_drafts(),
        *fir_loaded_drafts(),
        *weight_kf_drafts(),
        *mass_drafts(),
        *frame_drafts(),
        *golden_adaptive.drafts(),
        *golden_imu.drafts(),
        *golden_mahony.drafts(),
        *golden_scale.drafts(),
        *golden_checkweigher.drafts(),
        *golden_settings.drafts(),
        *golden_faults.drafts(),
        *golden_temperature.drafts(),
        *golden_zupt.drafts(),
        *golden_zupt_gru.drafts(),
    ]


def write_all(folder: Path = FOLDER) -> list[Path]:
    """Write those whose content has changed; files that no draft names are removed."""
    folder.mkdir(parents=True, exist_ok=True)
    mark, written = generator_mark(), []
    wanted = {f"{draft.name}.csv": draft for draft in drafts()}
    for path in folder.glob("*.csv"):
        if path.name not in wanted:
            path.unlink()
    for name, draft in wanted.items():
        path = folder / name
        text = text_of(draft, mark)
        if not path.is_file() or content(path.read_text(encoding="utf-8")) != content(text):
            path.write_text(text, encoding="utf-8")
            written.append(path)
    return written


def content(text: str) -> list[str]:
    """A vector's text without what says only who made it."""
    return [
        line for line in text.splitlines() if not line.startswith(("# generator", "# libraries"))
    ]
