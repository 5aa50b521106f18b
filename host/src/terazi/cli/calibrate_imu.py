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
    rehearse: int  # simulated boards; 0: a real one
    level: bool

    @property
    def is_any(self) -> bool:
        return self.imu or self.mag or self.self_test or self.level

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
        if self.rehearse and (not self.imu or self.mag or self.self_test or self.source):
            raise UsageError("--rehearse goes with --imu, and with nothing else")
        if self.board_free and self.six_only:
            raise UsageError("--board-free wants no faces, --six-only nothing else")
        if self.level and (self.imu or self.mag or self.self_test or self.source):
            raise UsageError("--level stands for itself: it wants the board as it is in use")
        if self.self_test and (self.mag or self.source or self.dry_run):
            raise UsageError("--self-test stands for itself: it changes nothing")


def run(wish: Wish, port: str | None, baud, asks: bool, wait_s: float, as_json: bool) -> None:
    """What is wished for, on a live board or from a recording."""
    from terazi.calibration.imu.dialogue import Plan
    from terazi.cli.terminal import RichTerminal

    terminal = RichTerminal(errors if as_json else out)
    if wish.rehearse:
        _rehearse(wish.rehearse, as_json)
        return
    if wish.level:
        from terazi.calibration.imu.level import set_level

        with board(port, baud) as link:
            found = set_level(link, terminal, asks=asks, wait_s=wait_s, dry_run=wish.dry_run)
        if as_json:
            print(json.dumps({"settings": found.settings, "off_deg": found.off_deg}))
        return
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


def _rehearse(boards: int, as_json: bool) -> None:
    from dataclasses import asdict

    from rich.progress import track
    from rich.table import Table

    from terazi.calibration.imu.rehearsal import rehearse, worst

    seeds = range(1, boards + 1)
    rows = [rehearse(seed) for seed in track(seeds, "working ...", console=errors, transient=True)]
    most = worst(rows)
    if as_json:
        print(json.dumps({"worst": most, "boards": [asdict(one) for one in rows]}))
        return
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("board")
    for heading in (
        *("offset\nmg", "scale\n%", "cross axes\n%", "gyroscope\n%", "its bias\ndeg/s"),
        *("gravity off\nmg, before", "after\nmg"),
    ):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        table.add_row(*(_figures(asdict(row))))
    table.add_row(*_figures({"seed": "worst", **most}), style="bold")
    out.print(table)
    out.print(
        "What is left of 80 mg, 3 %, 2 % across, 20 deg/s and 400 ug/rtHz after six sides and six "
        "slants, as the device's integers hold it.",
        style="dim",
    )


def _figures(row: dict) -> list[str]:
    seed, *figures = row.values()
    return [str(seed), *(f"{value:.3f}" for value in figures)]
