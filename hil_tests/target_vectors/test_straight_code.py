# SPDX-License-Identifier: MIT
"""What tools/gen/fir_asm writes is right for any coefficients, not just for those that ship.

The runner is linked anew with straight code of other coefficients in place of the default design's.
The filter keeps its 32 samples; shorter code takes the oldest of them, and so answers later.
"""

import random
import re
import subprocess
from pathlib import Path

import pytest

from target_vectors.avr_core import AvrCore
from terazi.design import specs
from terazi.models import exact
from tools.gen import fir_asm

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / ".build"
WINDOW = 32
DEFAULT = BUILD / "firmware/firmware/port/generated/port_fir_default.S.o"
RECIPE = Path(__file__).with_name("Makefile").read_text(encoding="utf-8")
# Each serves in place of runner.o, in an image of its own.
OTHER_RUNNERS = tuple(
    BUILD / f"target_vectors/runner_{name}.o"
    for name in re.search(r"^APART +:= (.+)$", RECIPE, re.MULTILINE)[1].split()
)

DESIGNS = {
    "passband32": specs.fir_taps_q15("passband32").tolist(),  # negative ones
    "hamming15": specs.fir_taps_q15("hamming15").tolist(),  # a middle one
    # bytes that are 0 or 1, both signs, a coefficient of 0, and the most gain that is lawful
    "corners13": [0, -1, 255, -256, 257, 1000, 30258, 1000, 257, -256, 255, -1, 0],
    "most8": [-4095, -4096, 8191, 16384, 16384, 8191, -4096, -4095],
    "least2": [16384, 16384],
}


def shipped() -> list[Path]:
    """Objects of the runner but the straight code; a build keeps those of sources that are gone."""
    firmware, runners = BUILD / "firmware", BUILD / "target_vectors"
    built = {
        path: ROOT / path.relative_to(firmware).with_suffix("")
        for part in ("shared_c", "firmware/port")
        for path in sorted((firmware / part).rglob("*.o"))
    }
    built |= {
        path: Path(__file__).with_name(path.with_suffix(".c").name)
        for path in sorted(runners.glob("*.o"))
    }
    left_out = (DEFAULT, *OTHER_RUNNERS)
    return [path for path, source in built.items() if source.exists() and path not in left_out]


def linked(folder: Path, name: str, taps: list[int]) -> Path:
    """The runner with straight code for taps."""
    source, target, elf = folder / "code.S", folder / "code.o", folder / f"{name}.elf"
    source.write_text(fir_asm.text_of(taps, name, "for a test"))
    machine = ["avr-gcc", "-mmcu=atmega328p"]
    subprocess.run([*machine, "-c", str(source), "-o", str(target)], check=True)
    link = [*machine, "-Wl,--gc-sections", *map(str, shipped()), str(target), "-o", str(elf)]
    subprocess.run(link, check=True)
    return elf


@pytest.mark.parametrize("name", DESIGNS)
def test_straight_code_of_any_coefficients_is_the_exact_twin(runner_elf, tmp_path, name):
    taps = DESIGNS[name]
    rng = random.Random(len(taps))
    samples = [rng.randint(exact.COUNTS_MIN, exact.COUNTS_MAX) for _ in range(100)]
    samples += [exact.COUNTS_MAX] * 40 + [exact.COUNTS_MIN] * 40 + [0, 1, -1] * 10
    worst = [exact.COUNTS_MAX if tap > 0 else exact.COUNTS_MIN for tap in taps]
    samples += worst * 2 + [-1 - value for value in worst] * 2
    late = WINDOW - len(taps)
    expected, clipped = exact.fir([0] * late + samples[: len(samples) - late], taps, 0)
    results, counted = AvrCore(linked(tmp_path, name, taps)).fir(0, 0, samples, by_heart=True)
    assert results == expected
    assert counted == clipped


def test_rows_out_of_reach_are_refused_and_columns_that_would_overflow():
    with pytest.raises(ValueError, match="out of reach"):
        fir_asm.text_of([512] * 64, "long", "")
    assert not fir_asm.is_signed((0, 2**24 - 1))
    assert fir_asm.is_signed((-(2**23), 2**23 - 1))
    for beyond in ((0, 2**24), (-1, 2**23), (-(2**23) - 1, 0)):
        with pytest.raises(ValueError, match="cannot hold"):
            fir_asm.is_signed(beyond)
