# SPDX-License-Identifier: MIT
"""The conversation that calibrates an IMU: nobody presses a key, lying still is enough.

Until its end the board measures by its old calibration; ctrl-C or "abort" leave it as it was.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from terazi.applications.attitude.calibrated import setting_names
from terazi.applications.attitude.records import Record, of_inertial
from terazi.calibration.imu import positions, show
from terazi.calibration.imu.board import ImuBoard
from terazi.calibration.imu.fit import (
    Contradiction,
    FieldResult,
    MotionResult,
    fit_field,
    fit_motion,
    relate,
)
from terazi.calibration.imu.magnetometer import TURN_MORE, coverage
from terazi.calibration.imu.standstill import STILL_S, Finder, Standstill, find
from terazi.calibration.terminal import Terminal
from terazi.control.balance import Balance
from terazi.control.settings import apply_settings, read_settings
from terazi.errors import Aborted, CalibrationRefused, CannotRead, TeraziError
from terazi.link import Link
from terazi.link.generated.messages import MagKind, SaveSettings
from terazi.recorder.inertial import counts_of
from terazi.units import ACC_COUNTS_PER_STANDARD_GRAVITY as ONE_G

ABORT = {"abort": "end; the board stays as it was"}
TURN_S = 0.1
EVERY = 2  # 250 IMU messages a second, and 70 MAG, are two thirds of 115 200 baud
COVERED_WELL = 0.85
FIELD_LEAST = 60  # samples before a coverage means anything


@dataclass(frozen=True)
class Plan:
    """wait_s: for the next position, or for more of the field to be seen."""

    motion: bool = True  # accelerometer and gyroscope
    field: bool = False  # magnetometer
    asks: bool = True
    wait_s: float = 60.0
    free: bool = False  # twelve positions of any kind, for what has no sides
    slants: bool = True  # after the six, for cross axes
    dry_run: bool = False


@dataclass
class Outcome:
    """What came of it; settings by name, empty where nothing was wanted."""

    motion: MotionResult | None = None
    field: FieldResult | None = None
    settings_saved: int | None = None  # number of the record in EEPROM; None: nothing was written

    @property
    def settings(self) -> dict[str, int]:
        """All that is to be set."""
        results = (one for one in (self.motion, self.field) if one is not None)
        return {name: value for one in results for name, value in one.settings.items()}


def calibrate_imu(link: Link, terminal: Terminal, plan: Plan) -> Outcome:
    """The whole conversation. Raises CalibrationRefused, Aborted, and what the link raises."""
    outcome = Outcome()
    with _Sitting(link, terminal, plan) as sitting:
        if plan.field:
            sitting.want_magnetometer()
        if plan.motion:
            outcome.motion = sitting.motion()
        if plan.field:
            outcome.field = sitting.field()
        if plan.motion and plan.field:
            relate(*sitting.lain, outcome.motion, outcome.field, sitting.before)
    return write(link, terminal, outcome, plan)


def of_record(record: Record, plan: Plan, before: Mapping[str, int] | None = None) -> Outcome:
    """The same from a recording. before: settings that held; None: those of the factory."""
    before = before or {n: 0 for group in groups_of(plan) for n in setting_names(group)}
    outcome = Outcome()
    if plan.motion:
        stills = find(record.acc_b_counts, record.gyro_b_counts, record.rate_hz)
        outcome.motion = fit_motion(record, stills, before, free=plan.free)
    if plan.field:
        if record.mag_b_counts is None:
            raise CannotRead(f"{record.name} holds no magnetometer", remedy="Leave --mag out.")
        outcome.field = fit_field(record.mag_b_counts, before)
        if plan.motion:
            relate(record, stills, outcome.motion, outcome.field, before)
    return outcome


def groups_of(plan: Plan) -> list[str]:
    """Whose settings a plan is about."""
    return [*(["acc", "gyro"] if plan.motion else []), *(["mag"] if plan.field else [])]


def present(link: Link, plan: Plan) -> dict[str, int]:
    """The calibration that holds by now."""
    names = [name for group in groups_of(plan) for name in setting_names(group)]
    Balance(link).quiet_stream()  # a line that is full of attitudes has no room for answers
    return read_settings(link, [*names, "imu.orientation", "mag.orientation"])


def write(link: Link | None, terminal: Terminal, outcome: Outcome, plan: Plan) -> Outcome:
    """Show, have agreed to, set, save and read back. link: None for a dry run of a recording."""
    show.outcome(terminal, outcome.motion, outcome.field)
    if plan.dry_run or link is None:
        show.settings(terminal, outcome.settings)
        terminal.tell("Dry run: the board stays as it was.", tone="soft")
        return outcome
    if plan.asks:
        choices = {"save": "measure by this from now on", "leave": "leave the board as it is"}
        if terminal.choose("What now?", choices) != "save":
            return outcome
    balance = Balance(link)
    balance.quiet_stream()
    before = apply_settings(link, outcome.settings)
    try:
        balance.obey(SaveSettings())
        outcome.settings_saved = balance.wait_saved()
        held = read_settings(link, outcome.settings)
    except TeraziError:
        apply_settings(link, before)
        raise
    if held != outcome.settings:
        raise TeraziError(f"{link.name} holds another calibration than was set")
    terminal.tell("The calibration holds; saved, and read back.", tone="good")
    return outcome


class _Sitting:
    """A board in hand, from the first sample to the last."""

    def __init__(self, link: Link, terminal: Terminal, plan: Plan) -> None:
        self.link, self.terminal, self.plan = link, terminal, plan
        self.before = present(link, plan)
        self.board = ImuBoard(link, every=EVERY)
        self.finder = Finder(self.board.rate_hz)
        self._fed = 0
        self.lain: tuple[Record, list[Standstill]]  # what the positions came of

    def __enter__(self) -> _Sitting:
        self.board.__enter__()
        return self

    def __exit__(self, *exception) -> None:
        self.terminal.live("")
        self.board.__exit__(*exception)

    # Positions.

    @property
    def ups(self) -> list[np.ndarray]:
        """Of all standstills so far."""
        return [one.up for one in self.finder.found]

    def motion(self) -> MotionResult:
        """Positions until they will do, and what comes of them."""
        self.board.forget()
        if self.plan.free:
            self.terminal.tell(
                f"Let the board lie still for 3 s in {positions.FREE_POSITIONS} positions that "
                "differ as much as they can: on each end, edge and corner, upside down too."
            )
        else:
            self.terminal.tell(
                "Put the board on each of its six sides, in any order, and let it lie still for "
                "3 s each. Hold it against a box or a book: nothing need be exactly level."
            )
        while True:
            try:
                self._take_positions()
                self.lain = (self._record(), list(self.finder.found))
                return fit_motion(*self.lain, self.before, free=self.plan.free)
            except CalibrationRefused as refused:
                if not self.plan.asks:
                    raise
                self._again(refused)

    def _record(self) -> Record:
        """All samples, numbered as the finder has them."""
        record = of_inertial(self.board.inertial, "the sitting")
        if len(record) < self._fed:
            raise CalibrationRefused(
                "the board started anew in the middle of it",
                remedy="Look to its supply and its cable.",
            )
        return record

    def _again(self, refused: CalibrationRefused) -> None:
        """After a refusal: what is wrong goes, and more is taken."""
        show.error(self.terminal, refused)
        choices = {"again": "begin with the positions anew"}
        if isinstance(refused, Contradiction):
            choices = {"replace": "forget that position, and take it once more"} | choices
        if self._choose(choices) == "replace":
            del self.finder.found[refused.worst]
            return
        self.board.forget()
        self.finder, self._fed = Finder(self.board.rate_hz), 0

    def _take_positions(self) -> None:
        if self.plan.free:
            self._until(self._wanted_free, lambda: False)
            return
        self._until(lambda: positions.missing_faces(self.ups), lambda: False)
        if self.plan.slants and positions.missing_slants(self.ups):
            self.terminal.tell(
                "The six are there. Now lean it at a slant, half-way between two sides: these "
                "tell how its axes stand to one another."
            )
            self._until(lambda: positions.missing_slants(self.ups), lambda: True)

    def _wanted_free(self) -> list[str]:
        there = len(positions.distinct(self.ups))
        if there >= positions.FREE_POSITIONS:
            return []
        return [f"{positions.FREE_POSITIONS - there} more, such as {positions.emptiest(self.ups)}"]

    def _until(self, missing: Callable[[], list[str]], may_go_on: Callable[[], bool]) -> None:
        """Follow the board until nothing is missing; after wait_s without a new position, what
        is missing is told, and what to do asked."""
        self._tell_missing(missing())
        end_s = self.link.now_s() + self.plan.wait_s
        while wanted := missing():
            if self._turn():
                self.terminal.live("")
                self.terminal.tell(f"{positions.name_of(self.ups[-1])}: taken", tone="good")
                self._tell_missing(missing())
                end_s = self.link.now_s() + self.plan.wait_s
            elif self.link.now_s() > end_s:
                if self._gives_up(wanted, may_go_on()):
                    return
                end_s = self.link.now_s() + self.plan.wait_s

    def _turn(self) -> bool:
        """Some samples more; whether they end with a position that was not there before."""
        self.board.follow(TURN_S)
        before = len(self.finder.found)
        acc, gyro = self.board.newest(self._fed)
        self._fed += len(acc)
        self.finder.feed(acc, gyro)
        self.terminal.live(self._live_words())
        return len(self.finder.found) > before

    def _live_words(self) -> str:
        finder = self.finder
        acc = finder.latest[:3]
        length = float(np.linalg.norm(acc))
        if not length:
            return "no samples yet"
        words = f"{positions.name_of(acc / length)}  {length / ONE_G:.3f} g"
        if not finder.is_quiet:
            return f"{words}  moves by {finder.shake_deg_s:.1f} deg/s"
        return f"{words}  lies still, {min(finder.still_s, STILL_S):.1f} of {STILL_S:g} s"

    def _tell_missing(self, wanted: list[str]) -> None:
        if not wanted:
            return
        self.terminal.tell(f"Missing: {', '.join(wanted)}.", tone="soft")
        if wanted[0] in positions.FACES and len(wanted) < len(positions.FACES):
            self.terminal.tell(positions.hint(wanted, self.ups) + ".", tone="soft")

    def _gives_up(self, wanted: list[str], may_go_on: bool) -> bool:
        """Nothing new has come for long: go on without what is missing?"""
        if not self.plan.asks:
            if may_go_on:
                return True
            raise CalibrationRefused(
                f"no new position within {self.plan.wait_s:g} s; missing: {', '.join(wanted)}",
                remedy="Give it longer with --wait.",
            )
        choices = {"wait": "go on waiting"}
        if may_go_on:
            choices["fit"] = "go on with what there is"
        return self._choose(choices) == "fit"

    # The field.

    def want_magnetometer(self) -> None:
        """Raises CalibrationRefused where there is none, before anything else is begun."""
        self.board.follow(1.5)  # an IMU_STATUS comes every second
        if self.board.status is not None and self.board.status.mag_kind == MagKind.NONE:
            raise CalibrationRefused(
                "the board has no magnetometer: nothing answers as a QMC5883L or HMC5883L",
                remedy="Wire one beside the MPU-6050, or leave --mag out.",
            )

    def field(self) -> FieldResult:
        """The magnetometer turned about, and what comes of it."""
        self.board.forget()
        self.terminal.tell(f"{TURN_MORE} Keep it in one place, away from iron, magnets and cables.")
        while True:
            try:
                return self._turn_about()
            except CalibrationRefused as refused:
                if not self.plan.asks:
                    raise
                show.error(self.terminal, refused)
                self._choose({"more": "go on turning it"})

    def _turn_about(self) -> FieldResult:
        """What comes of it once all directions were seen; CalibrationRefused where nothing new has
        come for long."""
        seen, end_s = 0.0, self.link.now_s() + self.plan.wait_s
        while self.link.now_s() < end_s:
            self.board.follow(2 * TURN_S)
            raw = counts_of(self.board.inertial.mag).astype(np.float64)
            if len(raw) < FIELD_LEAST:
                continue
            now = coverage(raw - (raw.max(axis=0) + raw.min(axis=0)) / 2)
            if now > seen:
                seen, end_s = now, self.link.now_s() + self.plan.wait_s
            # The middle of what was seen is not the field's: the fit may still want more.
            if seen >= COVERED_WELL:
                with contextlib.suppress(CalibrationRefused):
                    return fit_field(counts_of(self.board.inertial.mag), self.before)
            self.terminal.live(f"{seen:.0%} of all directions seen, {COVERED_WELL:.0%} will do")
        self.terminal.live("")
        return fit_field(counts_of(self.board.inertial.mag), self.before)

    def _choose(self, choices: dict[str, str]) -> str:
        chosen = self.terminal.choose("What now?", choices | ABORT)
        if chosen == "abort":
            raise Aborted("calibration aborted; the board is as it was")
        self.board.resume()
        return chosen
