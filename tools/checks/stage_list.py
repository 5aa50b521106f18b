# SPDX-License-Identifier: MIT
"""The stages of ``./dev test``, in order: what is quick and tells most comes first."""

import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / ".build/results"
C_OBJECTS = ".build/coverage/objects"
WORKERS = "2"
WAITING_WORKERS = "3"  # where tests wait for others' answers half of the time
# A million samples tell of accuracy; they take no branch and no rail that a few do not.
LONG = "within_one_count_of_the_model"

# Of all branches. Raise a number when the tests beat it.
C_BRANCHES_MIN_PERCENT = 97
PYTHON_MIN_PERCENT = 90


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


def counted(name: str) -> dict[str, str]:
    """Where a stage leaves its coverage of Python."""
    return {"COVERAGE_FILE": str(RESULTS / f"{name}.coverage")}


def coverage(_: Path) -> list[list[str]]:
    """C by a build that counts, Python from what the stages before left."""
    parts = [str(RESULTS / f"{name}.coverage") for name in ("host", "hil")]
    of_c = f"--root {C_OBJECTS} {C_OBJECTS} --exclude .*_cshared.c --exclude .*blocks.c"
    limits = f"--fail-under-line 100 --fail-under-branch {C_BRANCHES_MIN_PERCENT}"
    return [
        python("-m", "coverage", "combine", "--keep", *parts),
        python("-m", "coverage", "report", f"--fail-under={PYTHON_MIN_PERCENT}"),
        python(
            *f"-m pytest -q -n {WORKERS} -p tools.checks.c_coverage host/tests/shared_c".split(),
            *("-k", f"not {LONG}"),
        ),
        python(*f"-m gcovr {of_c} --txt-metric branch {limits}".split()),
    ]


def pytest(name: str, *arguments: str, workers: str = WORKERS) -> Callable[[Path], list[list[str]]]:
    return lambda results: [
        python(
            *("-m", "pytest", "-n", workers, "--dist", "worksteal"),
            *(f"--junitxml={results / name}.xml", *arguments),
        )
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
        pytest("host", "host", "--cov", "--cov-report=", workers=WAITING_WORKERS),
        environment=counted("host"),
    ),
    Stage(
        "sanitized",
        "shared_c again, where undefined behaviour ends the run",
        pytest("sanitized", "host/tests/shared_c", "--sanitized", "-k", f"not {LONG}"),
    ),
    Stage(
        "hil",
        "the whole system on the virtual Uno, vectors inside the AVR binary, flashing",
        pytest(
            *("hil", "hil_tests", "--uno=virtual", "--cov", "--cov-report="),
            workers=WAITING_WORKERS,
        ),
        environment=counted("hil"),
    ),
    Stage(
        "coverage",
        f"tests take {C_BRANCHES_MIN_PERCENT} % of the branches of shared_c, "
        f"{PYTHON_MIN_PERCENT} % of Python",
        coverage,
        environment=counted("all"),
        stops_at_first_failure=False,
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
