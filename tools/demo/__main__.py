# SPDX-License-Identifier: MIT
"""Boot the virtual Uno, log it, replay the recording, report it: four steps, real commands.

Everything it makes lies in .build/demo: weighing.terazi with its tables, truth.csv, report.html.
"""

import argparse
import os
import shlex
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tools.demo.scenario import LOADS_S_G, SECONDS

ROOT = Path(__file__).resolve().parents[2]
FOLDER = Path(".build/demo")
IMAGE = Path(".build/firmware/terazi.elf")
PORT = FOLDER / "uno"
TRUTH = FOLDER / "truth.csv"
CAPTURE = FOLDER / "weighing.terazi"
REPORT = FOLDER / "report.html"

RATE_SPS = 82.0  # the HX711's clock has no stated tolerance; nothing may lean on 80
BOOT_TIMEOUT_S = 20.0
STOP_TIMEOUT_S = 5.0


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


@contextmanager
def virtual_uno(speed: float) -> Iterator[None]:
    """The bench as a program of its own, for as long as the block lasts."""
    command = [sys.executable, "-m", "virtual_uno", "--elf", IMAGE, "--link", PORT]
    command += ["--rate", RATE_SPS, "--speed", f"{speed:g}"]
    command += ["--scenario", "tools.demo.scenario:grams"]
    log = FOLDER / "virtual_uno.log"
    with log.open("w") as output:
        bench = subprocess.Popen(
            [str(word) for word in command], stdout=output, stderr=subprocess.STDOUT
        )
        try:
            deadline_s = time.monotonic() + BOOT_TIMEOUT_S
            while not PORT.exists():
                if bench.poll() is not None or time.monotonic() > deadline_s:
                    raise DemoFailed(f"the virtual Uno did not start:\n{log.read_text()}")
                time.sleep(0.05)
            yield
            if bench.poll() not in (None, 0):
                raise DemoFailed(f"the virtual Uno ended early:\n{log.read_text()}")
        finally:
            if bench.poll() is None:
                bench.send_signal(signal.SIGINT)
            try:
                bench.wait(STOP_TIMEOUT_S)
            except subprocess.TimeoutExpired:
                bench.kill()
                bench.wait()


def write_truth() -> None:
    """The weights alone: what a perfect scale would say. The report fits its clock by the steps."""
    rows = [*LOADS_S_G, (SECONDS, LOADS_S_G[-1][1])]
    lines = ["t_s,load_g", *(f"{start_s:g},{total_g:g}" for start_s, total_g in rows)]
    TRUTH.write_text("\n".join(lines) + "\n", encoding="utf-8")


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
    with virtual_uno(speed):
        step(2, "It is logged as a board on a serial port would be")
        run(terazi("log", PORT, "-o", CAPTURE, "--seconds", f"{SECONDS / speed:g}"))
    step(3, "The recording goes through the same C on this machine, and through the float models")
    run(terazi("replay", CAPTURE))
    step(4, "What came of it")
    write_truth()
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
    except DemoFailed as error:
        print(f"demo: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("\ndemo: stopped", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
