# SPDX-License-Identifier: MIT
"""Random faults injected into the shipped image while it weighs: is a wrong weight ever stable?

    ./dev run python -m tools.measure.faults --samples 1000000

The converter and its wires fail at random, in every way that the bench knows, loads come and go.
A weight is wrong that lies more than 1 e outside every load of the filters' memory. Also told: how
long the device took to name each fault, and to forget it once it was over. Exit code 1 if a weight
was wrong, or a fault was named or forgotten late.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from terazi.link import Link
from terazi.link.generated.messages import (
    Fault,
    FaultFlag,
    Sample,
    SetSetting,
    Setting,
    Status,
    Weight,
    WeightFlag,
)
from terazi.link.generated.settings import SettingKey
from virtual_uno import Uno

IMAGE = Path(__file__).resolve().parents[2] / ".build" / "firmware" / "terazi.elf"
E_MG = 1000.0
MEMORY = 64  # conversions: the FIR's 32 and the Kalman filter's settling
SPOILS = FaultFlag(0x3F)
SLICE_S = 0.004
RECOVERY_S = 1.0
SLOW_STABLE_US = 3_000_000  # at 10 SPS the time must span the FIR

# Fault of the bench -> its details, what it is called if it lasts, whether it comes once.
KINDS = {
    "cable_out": (lambda rng: {}, FaultFlag.CABLE_OUT),
    "dout_high": (lambda rng: {}, FaultFlag.CABLE_OUT),
    "dout_low": (lambda rng: {}, FaultFlag.DOUT_STUCK),
    "rail": (lambda rng: {"side": rng.choice(["high", "low"])}, FaultFlag.AT_RAIL),
    "rate": (lambda rng: {"factor": float(rng.uniform(20, 40))}, FaultFlag.RATE_OUT_OF_RANGE),
    "noise": (lambda rng: {"counts": 10 ** float(rng.uniform(5.3, 6.1))}, FaultFlag.NOISE_HIGH),
    "frozen": (lambda rng: {}, FaultFlag.DOUT_STUCK),
    "noisy_line": (lambda rng: {"probability": 10 ** float(rng.uniform(-3, -1))}, None),
    "other_rate": (lambda rng: {"factor": float(rng.uniform(0.7, 1.4))}, None),
    "glitch": (lambda rng: {}, None),
    "conversion_lost": (lambda rng: {"count": int(rng.integers(1, 6))}, None),
    "late": (lambda rng: {"seconds": float(rng.uniform(0.001, 0.5))}, None),
    "bit_lost": (lambda rng: {"bit": int(rng.integers(1, 26)), "frames": 1}, None),
    "stretched": (lambda rng: {"bit": int(rng.integers(1, 26)), "frames": 1}, None),
}
BENCH_NAME = {"other_rate": "rate"}
LONGER = {"frozen": 6.5, "noise": 12.0}  # conversions, see shared_c/notes/faults.md


@dataclass
class Figures:
    """What a run found."""

    samples: int = 0
    stable: int = 0
    wrong: int = 0
    worst_e: float = 0.0
    injected: Counter = field(default_factory=Counter)
    named_ms: dict[str, float] = field(default_factory=dict)  # the longest
    forgotten_ms: dict[str, float] = field(default_factory=dict)
    late: list[str] = field(default_factory=list)

    def longest(self, table: dict[str, float], kind: str, seconds: float) -> None:
        table[kind] = round(max(table.get(kind, 0.0), seconds * 1e3), 1)

    def as_json(self) -> str:
        return json.dumps({**self.__dict__, "injected": dict(self.injected)}, indent=2)


class _Line:
    """The link's transport: bytes come with the bench's time."""

    def __init__(self, uno: Uno) -> None:
        self._uno = uno

    def read(self, timeout_s: float) -> bytes:
        end_s = self._uno.seconds + timeout_s
        while not (data := self._uno.uart.read()) and self._uno.seconds < end_s:
            self._uno.run(min(SLICE_S, end_s - self._uno.seconds) + 1e-7)
        return data

    def write(self, data: bytes) -> None:
        self._uno.uart.write(data)

    def now_s(self) -> float:
        return self._uno.seconds

    def close(self) -> None:
        pass


class Injection:
    """One board and its misfortunes."""

    def __init__(self, *, rate_sps: float, seed: int, elf: Path = IMAGE) -> None:
        slow = rate_sps < 40
        self.rate_sps = rate_sps
        self.rng = np.random.default_rng(seed)
        self.uno = Uno(elf, rate_sps=rate_sps, noise_counts=21.5 if slow else 38.7, seed=seed)
        self.link = Link(_Line(self.uno), name="the virtual Uno")
        self.figures = Figures()
        self.faults = FaultFlag(0)
        self.loads = [(0.0, 0.0)]  # since when, mg; what left the filters long ago is forgotten
        self.link.hello()
        if slow:
            command = SetSetting(SettingKey.SCALE_STABLE_US, SLOW_STABLE_US)
            self.link.ask(command, Setting, key=SettingKey.SCALE_STABLE_US)
        self.wait(MEMORY / rate_sps)

    def load(self, grams: float) -> None:
        self.uno.load(grams=grams)
        self.loads.append((self.uno.seconds, grams * 1000.0))

    def wait(self, seconds: float) -> None:
        end_s = self.uno.seconds + seconds
        while (left_s := end_s - self.uno.seconds) > 0:
            for one in self.link.poll(left_s):
                self.take(one.message)

    def take(self, message: object) -> None:
        if isinstance(message, Fault | Weight | Status):
            self.faults = message.faults & SPOILS
        elif isinstance(message, Sample):
            self.figures.samples += 1
            if WeightFlag.STABLE in message.weight_flags:
                self.judge(message.mass_mg)

    def judge(self, mass_mg: float) -> None:
        long_ago_s = self.uno.seconds - MEMORY / self.rate_sps - SLICE_S
        while len(self.loads) > 1 and self.loads[1][0] < long_ago_s:
            del self.loads[0]
        low, high = min(mg for _, mg in self.loads), max(mg for _, mg in self.loads)
        off_mg = max(low - mass_mg, mass_mg - high, 0.0)
        self.figures.stable += 1
        self.figures.wrong += off_mg > E_MG
        self.figures.worst_e = max(self.figures.worst_e, round(off_mg / E_MG, 3))

    def until(self, predicate, most_s: float) -> float | None:
        """Seconds until it holds, None if it took longer."""
        begin_s = self.uno.seconds
        while not predicate():
            if self.uno.seconds - begin_s > most_s:
                return None
            self.wait(SLICE_S)
        return self.uno.seconds - begin_s

    def inject(self) -> None:
        """One fault from its beginning to its end, and often what follows it."""
        kind = str(self.rng.choice(list(KINDS)))
        details, named = KINDS[kind]
        was_well = not self.faults
        self.figures.injected[kind] += 1
        self.uno.fault(BENCH_NAME.get(kind, kind), **details(self.rng))
        period_s = 1.0 / self.rate_sps
        most_s = max(0.150, 3 * period_s, LONGER.get(kind, 0.0) * period_s) + SLICE_S
        if named and was_well and self.rng.random() < 0.5:
            took_s = self.until(lambda: self.faults & named, most_s)
            if took_s is None:
                self.figures.late.append(f"{kind} not named in {most_s * 1e3:.0f} ms")
            else:
                self.figures.longest(self.figures.named_ms, kind, took_s)
        if self.rng.random() < 0.4:
            self.wait(float(self.rng.uniform(0, 20)) * period_s)
            self.load(self.some_grams())
        self.wait(float(self.rng.uniform(0, 60)) * period_s)
        self.uno.clear_faults()
        if self.rng.random() < 0.5:
            took_s = self.until(lambda: not self.faults, RECOVERY_S + SLICE_S)
            if took_s is None:
                self.figures.late.append(f"{kind} not forgotten: {self.faults!r}")
            else:
                self.figures.longest(self.figures.forgotten_ms, kind, took_s)

    def some_grams(self) -> float:
        return float(self.rng.choice([0.0, self.rng.uniform(5, 60), self.rng.uniform(60, 4500)]))

    def run(self, samples: int, told=lambda _: None) -> Figures:
        while self.figures.samples < samples:
            self.wait(float(self.rng.uniform(0, 180)) / self.rate_sps)
            if self.rng.random() < 0.35:
                self.load(self.some_grams())
            else:
                self.inject()
            told(self.figures)
        return self.figures


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m tools.measure.faults",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--samples", type=int, default=20_000, help="until so many have come")
    parser.add_argument("--rate", type=float, default=92.0, help="conversions a second")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    if sys.stderr.isatty():

        def told(figures: Figures) -> None:
            print(f"\r{figures.samples} samples, {figures.wrong} wrong", end="", file=sys.stderr)
    else:

        def told(_: Figures) -> None:
            pass

    figures = Injection(rate_sps=options.rate, seed=options.seed).run(options.samples, told)
    print(figures.as_json())
    return 1 if figures.wrong or figures.late else 0


if __name__ == "__main__":
    sys.exit(main())
