# SPDX-License-Identifier: MIT
"""Boot the virtual Uno, log it, replay the recording, report it: four steps, real commands.

Everything it makes lies in .build/demo: weighing.terazi with its tables, truth.csv, report.html.
"""

import argparse
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from tools.demo.scenario import LOADS_S_G, SECONDS
from tools.virtual_board import BoardFailed, virtual_board

ROOT = Path(__file__).resolve().parents[2]
FOLDER = Path(".build/demo")
IMAGE = Path(".build/firmware/terazi.elf")
PORT = FOLDER / "uno"
TRUTH = FOLDER / "truth.csv"
CAPTURE = FOLDER / "weighing.terazi"
REPORT = FOLDER / "report.html"

RATE_SPS = 82.0  # the HX711's clock has no stated tolerance; nothing may lean on 80


class DemoFailed(Exception):
    """One line that says what did not work."""


def terazi(*arguments: str | Path) -> list[str]:
    return [sys.executable, "-m", "terazi", *map(str, arguments)]


def step(number: int, claim: str) -> None:
    print(f"\n[{number}/4] {claim}", flush=True)


def run(command: list[str]) -> None:
    """Run a command of ours in sight of the person, so that it can be typed again."""
    print(f"      $ ./dev run terazi {shlex.join(command[3:])}", flush=True)
    done = subprocess.run(command, check=False)
    if done.returncode:
        raise DemoFailed(f"terazi {command[3]} ended with exit code {done.returncode}")


def open_report() -> None:
    """Show the report where there is a screen and somebody in front of it."""
    has_screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    opener = shutil.which("xdg-open")
    if has_screen and opener and sys.stdout.isatty():
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        subprocess.Popen([opener, str(REPORT)], start_new_session=True, **quiet)


def demo(speed: float, *, may_open: bool) -> None:
    loads = ", ".join(f"{total_g:g} g" for _, total_g in LOADS_S_G)
    step(1, "An Uno boots in the simulator: the same image that would be flashed")
    print(f"      loads {loads}; a machine shakes the bench, the mains hum, {RATE_SPS:g} SPS")
    scenario = ("--scenario", "tools.demo.scenario:grams", "--rate", RATE_SPS, "--speed", speed)
    with virtual_board(IMAGE, PORT, FOLDER / "virtual_uno.log", *scenario, "--truth", TRUTH):
        step(2, "It is logged as a board on a serial port would be")
        run(terazi("log", PORT, "-o", CAPTURE, "--seconds", f"{SECONDS / speed:g}"))
    step(3, "The recording goes through the same C on this machine, and through the float models")
    run(terazi("replay", CAPTURE))
    step(4, "What came of it")
    run(terazi("report", CAPTURE, "--truth", TRUTH, "-o", REPORT))
    print(f"\nThe report, to open in a browser: {(ROOT / REPORT).as_uri()}", flush=True)
    if may_open:
        open_report()


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="./dev demo", description=__doc__.splitlines()[0])
    parser.add_argument("--speed", type=float, default=1.0, help="simulated seconds a second")
    parser.add_argument("--no-open", action="store_true", help="do not open the report")
    options = parser.parse_args(arguments)
    if options.speed <= 0:
        parser.error("--speed must be above 0")
    os.chdir(ROOT)
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    try:
        demo(options.speed, may_open=not options.no_open)
    except (DemoFailed, BoardFailed) as error:
        print(f"demo: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("\ndemo: stopped", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
