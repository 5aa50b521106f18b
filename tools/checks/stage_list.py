# SPDX-License-Identifier: MIT
"""The stages of ``./dev test``, in order: what is quick and tells most comes first."""

import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

WORKERS = "2"


@dataclass(frozen=True)
class Stage:
    """Commands whose counts land in ``results/NAME.xml`` or ``.json``."""

    name: str
    claim: str
    commands: Callable[[Path], list[list[str]]]
    environment: dict[str, str] = field(default_factory=dict)
    stops_at_first_failure: bool = True


def python(*arguments: str) -> list[str]:
    return [sys.executable, *arguments]


def pytest(name: str, *arguments: str) -> Callable[[Path], list[list[str]]]:
    return lambda results: [
        python("-m", "pytest", "-n", WORKERS, f"--junitxml={results / name}.xml", *arguments)
    ]


STAGES = (
    Stage(
        "laws",
        "format, lint, layers, holes, staleness, warnings",
        lambda results: [python("-m", "tools.checks", "--counts", str(results / "laws.json"))],
    ),
    Stage(
        "host",
        "the host package, and shared_c on this machine",
        pytest("host", "host", "--cov", "--cov-report=term"),
    ),
    Stage(
        "sanitized",
        "shared_c again, where undefined behaviour ends the run",
        pytest("sanitized", "host/tests/shared_c", "--sanitized"),
    ),
    Stage(
        "hil",
        "the whole system on the virtual Uno, vectors inside the AVR binary, flashing",
        pytest("hil", "hil_tests", "--uno=virtual"),
    ),
    Stage(
        "port",
        "the cases through a serial port, on a virtual board that stands for a real one",
        lambda results: [
            python("-m", "tools.checks.second_board", f"--junitxml={results / 'port.xml'}")
        ],
    ),
    Stage(
        "pio",
        "PlatformIO builds the firmware without its registry",
        lambda _: [python("tools/flash/setup_platformio.py", "run", "-e", "uno-system")],
    ),
    Stage(
        "budget",
        "the image costs no more than firmware/budget.toml allows",
        lambda _: [python("-m", "tools.measure")],
    ),
)
