# SPDX-License-Identifier: MIT
"""`terazi calibrate --imu`, `--mag` and `--self-test`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from terazi.cli.board import board
from terazi.cli.common import errors, out


@dataclass(frozen=True)
class Wish:
    """The options that are about the IMU."""

    imu: bool
    mag: bool
    self_test: bool
    board_free: bool
    six_only: bool
    source: Path | None
    dry_run: bool

    @property
    def is_any(self) -> bool:
        return self.imu or self.mag or self.self_test

    def check(self) -> None:
        """Raises UsageError where options do not go together."""
        from terazi.errors import UsageError

        motion_only = {"--board-free": self.board_free, "--six-only": self.six_only}
        for name, given in motion_only.items():
            if given and not (self.imu and not self.self_test):
                raise UsageError(f"{name} belongs to --imu")
        if not self.is_any:
            for name, given in {"--from": self.source, "--dry-run": self.dry_run}.items():
                if given:
                    raise UsageError(f"{name} belongs to --imu or --mag")
        if self.board_free and self.six_only:
            raise UsageError("--board-free wants no faces, --six-only nothing else")
        if self.self_test and (self.mag or self.source or self.dry_run):
            raise UsageError("--self-test stands for itself: it changes nothing")


def run(wish: Wish, port: str | None, baud, asks: bool, wait_s: float, as_json: bool) -> None:
    """What is wished for, on a live board or from a recording."""
    from terazi.calibration.imu.dialogue import Plan
    from terazi.cli.terminal import RichTerminal

    terminal = RichTerminal(errors if as_json else out)
    if wish.self_test:
        _self_test(port, baud, terminal, as_json)
        return
    plan = Plan(
        motion=wish.imu,
        field=wish.mag,
        asks=asks,
        wait_s=wait_s,
        free=wish.board_free,
        slants=not wish.six_only,
        dry_run=wish.dry_run,
    )
    if wish.source is None:
        from terazi.calibration.imu.dialogue import calibrate_imu

        with board(port, baud) as link:
            outcome = calibrate_imu(link, terminal, plan)
    else:
        outcome = _from_recording(wish.source, port, baud, terminal, plan)
    if as_json:
        from terazi.calibration.imu.show import plain

        print(json.dumps(plain(outcome.motion, outcome.field, outcome.settings_saved)))


def _from_recording(source: Path, port, baud, terminal, plan):
    """Constants of a recording; written to a board unless it is a dry run."""
    from terazi.calibration.imu import dialogue
    from terazi.calibration.imu.recording import read

    record, before = read(source)
    if plan.dry_run:
        return dialogue.write(None, terminal, dialogue.of_record(record, plan, before), plan)
    with board(port, baud) as link:
        outcome = dialogue.of_record(record, plan, before or dialogue.present(link, plan))
        return dialogue.write(link, terminal, outcome, plan)


def _self_test(port, baud, terminal, as_json: bool) -> None:
    from terazi.calibration.imu.self_test import self_test, want_all

    with board(port, baud) as link:
        answers = self_test(link, terminal)
    if as_json:
        rows = [vars(one) | {"off": one.off, "passes": one.passes} for one in answers]
        print(json.dumps({"passes": all(one.passes for one in answers), "axes": rows}))
    want_all(answers)
