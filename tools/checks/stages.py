# SPDX-License-Identifier: MIT
"""``./dev test``: every stage, also after a failure, with its time; then one true line.

    python -m tools.checks.stages [--list | STAGE...]

Each stage writes its whole output to .build/log/test-STAGE.log and its counts to
.build/results/STAGE.xml (pytest) or .json (the others). A stage that leaves no counts, or that
fails without naming a failed test, counts as one failure.
"""

import json
import os
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from tools.checks.stage_list import STAGES, Stage

ROOT = Path(__file__).resolve().parents[2]
LOGS = ROOT / ".build/log"
RESULTS = ROOT / ".build/results"
TAIL_LINES = 40


@dataclass
class Outcome:
    """What a stage came to."""

    passed: int = 0
    failed: int = 0
    skipped: Counter[str] = field(default_factory=Counter)  # by reason
    failures: list[str] = field(default_factory=list)
    elapsed_s: float = 0.0

    def __str__(self) -> str:
        skipped = f", {self.skipped.total()} skipped" if self.skipped else ""
        return f"{self.passed} passed, {self.failed} failed{skipped}"


def from_junit(path: Path) -> Outcome:
    outcome = Outcome()
    for case in ElementTree.parse(path).iter("testcase"):
        kinds = {child.tag: child for child in case}
        if "failure" in kinds or "error" in kinds:
            outcome.failed += 1
            outcome.failures.append(f"{case.get('classname')}::{case.get('name')}")
        elif "skipped" in kinds:
            outcome.skipped[kinds["skipped"].get("message") or "no reason"] += 1
        else:
            outcome.passed += 1
    return outcome


def from_counts(path: Path) -> Outcome:
    counts = json.loads(path.read_text(encoding="utf-8"))
    return Outcome(passed=counts["passed"], failed=counts["failed"])


def outcome_of(stage: Stage, exit_code: int) -> Outcome:
    """The counts that the stage left, held against its exit code."""
    junit, counts = RESULTS / f"{stage.name}.xml", RESULTS / f"{stage.name}.json"
    try:
        if junit.exists():
            outcome = from_junit(junit)
        elif counts.exists():
            outcome = from_counts(counts)
        else:  # a plain command: one claim
            outcome = Outcome(passed=int(exit_code == 0))
    except (ElementTree.ParseError, ValueError, KeyError) as error:
        outcome = Outcome(failures=[f"unreadable counts: {error}"])
        exit_code = exit_code or 1
    if exit_code != 0 and outcome.failed == 0:
        outcome.failed = 1
        outcome.failures.append(f"exit code {exit_code}")
    if exit_code == 0 and outcome.passed == 0 and outcome.failed == 0:
        outcome.failed = 1
        outcome.failures.append("nothing was tested")
    return outcome


def run(stage: Stage) -> Outcome:
    for ending in ("xml", "json"):
        (RESULTS / f"{stage.name}.{ending}").unlink(missing_ok=True)
    log = LOGS / f"test-{stage.name}.log"
    start_s = time.monotonic()
    exit_code = 0
    with log.open("w", encoding="utf-8") as output:
        for command in stage.commands(RESULTS):
            output.write(f"$ {' '.join(command)}\n")
            output.flush()
            done = subprocess.run(
                command,
                cwd=ROOT,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env={**os.environ, **stage.environment},
                check=False,
            )
            exit_code = exit_code or done.returncode
            if exit_code and stage.stops_at_first_failure:
                break
    outcome = outcome_of(stage, exit_code)
    outcome.elapsed_s = time.monotonic() - start_s
    return outcome


def tell(stage: Stage, outcome: Outcome) -> None:
    print(f"{stage.name:10} {outcome!s:40} {outcome.elapsed_s:6.1f} s", flush=True)
    for reason, count in sorted(outcome.skipped.items()):
        print(f"           skipped {count}: {reason}")
    if not outcome.failed:
        return
    log = LOGS / f"test-{stage.name}.log"
    for line in log.read_text(encoding="utf-8", errors="replace").splitlines()[-TAIL_LINES:]:
        print(f"    {line}")
    for name in outcome.failures:
        print(f"    failed: {name}")
    print(f"    all of it: {log.relative_to(ROOT)}", flush=True)


def main(arguments: list[str]) -> int:
    if arguments == ["--list"]:
        for stage in STAGES:
            print(f"{stage.name:10} {stage.claim}")
        return 0
    names = [stage.name for stage in STAGES]
    if unknown := [name for name in arguments if name not in names]:
        print(f"no such stage: {' '.join(unknown)}; there are: {' '.join(names)}", file=sys.stderr)
        return 2
    for folder in (LOGS, RESULTS):
        folder.mkdir(parents=True, exist_ok=True)
    chosen = [stage for stage in STAGES if not arguments or stage.name in arguments]
    total, start_s = Outcome(), time.monotonic()
    for stage in chosen:
        if sys.stdout.isatty():
            print(f"{stage.name:10} {stage.claim} ...", end="\r", flush=True)
            print(end="\x1b[K")
        outcome = run(stage)
        tell(stage, outcome)
        total.passed += outcome.passed
        total.failed += outcome.failed
        total.skipped.update(outcome.skipped)
    print(f"{'all':10} {total!s:40} {time.monotonic() - start_s:6.1f} s")
    print(f"{total.passed} passed, {total.failed} failed")
    return 1 if total.failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
