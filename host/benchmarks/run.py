# SPDX-License-Identifier: MIT
"""``./dev bench [--json]``: how fast the host's filters and the virtual Uno are on this machine."""

import argparse
import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
IMAGE = ROOT / ".build/firmware/terazi.elf"
POLLING_IMAGE = ROOT / ".build/bench/polling.elf"


def measure() -> dict:
    """The object of ``--json``; its form stands in DESIGN.md."""
    import attitude
    import cycles
    import filters
    import simulator

    polling = simulator.polling_image(IMAGE, POLLING_IMAGE)
    return {
        "host": filters.throughput() | attitude.throughput(),
        "bench_realtime_factor": simulator.realtime_factor(polling),
        "bench_realtime_factor_asleep": simulator.realtime_factor(IMAGE),
        "accuracy": {**filters.accuracy(), "attitude": attitude.accuracy()},
        "cycles": cycles.measure(IMAGE),
    }


def show(figures: dict) -> None:
    print(f"{'host function':30} {'samples/s':>12} {'ratio':>8}  peer")
    for name, row in figures["host"].items():
        peer = f"{row['peer']}, {row['peer_per_s']:,} samples/s"
        print(f"{name:30} {row['ours_per_s']:12,} {row['ratio']:8.2f}  {peer}")
    print("\nvirtual Uno, simulated seconds a second")
    print(f"  firmware polling {figures['bench_realtime_factor']:8.1f}")
    print(f"  firmware asleep  {figures['bench_realtime_factor_asleep']:8.1f}")
    print("\nfixed point against float64, largest difference in counts")
    for name, counts in figures["accuracy"].items():
        if name != "attitude":
            print(f"  {name:36} {counts:10.4f}")
    show_attitude(figures["accuracy"]["attitude"])
    cycles = figures["cycles"]
    print(f"\n{'cycles of a whole call, AVR':30} {'least':>8} {'mean':>8} {'most':>8}")
    for name, row in cycles["variants"].items():
        print(f"{name:30} {row['min']:8} {row['mean']:8.0f} {row['max']:8}")
    print("\nthe most that a call costs in the firmware while it weighs at 80 SPS")
    for name, most in cycles["firmware_max"].items():
        print(f"  {name:36} {most:10}")


def show_attitude(figures: dict) -> None:
    if "skipped" in figures:
        print(f"\nattitude on BROAD's trials: skipped, {figures['skipped']}")
        return
    for axes in (6, 9):
        print(f"\nattitude, {axes} axes, {figures['trials']} BROAD trials: mean (worst) in deg")
        print(f"  {'':18} {'inclination':>16} {'heading':>16} {'total':>16}")
        for name, row in figures[f"axes_{axes}"].items():
            pairs = zip(row["mean"].values(), row["worst"].values(), strict=True)
            print(f"  {name:18}" + "".join(f" {m:7.2f} ({w:6.2f})" for m, w in pairs))


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="./dev bench", description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object, nothing else")
    options = parser.parse_args(arguments)
    figures = measure()
    if options.json:
        print(json.dumps(figures))
    else:
        show(figures)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
