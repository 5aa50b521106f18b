# SPDX-License-Identifier: MIT
"""The conversation that calibrates a scale, with a person or with a list of masses.

Until its end the device weighs by its old calibration; ctrl-C, a lost port or "abort" leave it
as it was.
"""

from dataclasses import dataclass

from terazi.calibration import points as judge
from terazi.calibration import range as scale_range
from terazi.calibration.check import check, suggestion
from terazi.calibration.session import Session
from terazi.calibration.talk import ABORT, Talk
from terazi.calibration.terminal import Terminal
from terazi.control.balance import Balance
from terazi.control.quantities import show_mass
from terazi.control.settings import apply_settings, read_settings
from terazi.design import scale as scale_design
from terazi.errors import CalibrationRefused, CommandRefused, UsageError
from terazi.link.generated.messages import Point, SaveSettings
from terazi.models.scale import mass_mg as curve_mass_mg
from terazi.units import counts_from_q7

# A load counts as changed when the weight is further than this from that of the point before, in
# the e that held until now.
CHANGED_E = 5
CHANGED_WAIT_S = 2.0  # so long a person's Enter may come before the mass
POINTS_USUAL = 2
MAX_LEAST_MG = 1000


@dataclass(frozen=True)
class Plan:
    """What is known before the conversation begins; what is None is asked for."""

    masses_mg: tuple[int, ...] | None = None
    max_mg: int | None = None
    interval_mg: int | None = None
    wait_s: float = 30.0  # for a load to be put on, and to stand still
    asks: bool = True  # False: nobody is there to answer
    takes_doubtful: bool = False  # without asking


@dataclass(frozen=True)
class Outcome:
    """What the device weighs by now."""

    points: list[Point]
    max_mg: int
    interval_mg: int
    settings_saved: int  # number of the record in EEPROM
    check_off_mg: int | None = None  # what the check weighing was off by; None: there was none


def calibrate(balance: Balance, terminal: Terminal, plan: Plan) -> Outcome:
    """The whole conversation. Raises CalibrationRefused, Aborted, and what the link raises."""
    return _Dialogue(balance, terminal, plan).run()


class _Dialogue:
    def __init__(self, balance: Balance, terminal: Terminal, plan: Plan) -> None:
        self.balance, self.terminal, self.plan = balance, terminal, plan
        self.talk = Talk(balance, terminal)
        self.session = Session(balance)
        self.max_mg = self.interval_mg = 0
        self._changed_mg = 0.0  # by the old calibration, what is another load
        self._old_points: list[Point] = []
        self._last_net_mg: int | None = None  # of the weight when the last point was taken
        self._empty_mg = 0.0  # by the old calibration, of the first point

    def run(self) -> Outcome:
        self.balance.quiet_stream()
        now = read_settings(self.balance.link, scale_range.RANGE_SETTINGS)
        self._old_points = self.balance.points()
        self._changed_mg = CHANGED_E * now["scale.interval_mg"]
        self._tell_what_is(now)
        self._agree_range(now)
        # Max and e come last: until then the board judges by the curve and the e that belong
        # together, and there is nothing to put back.
        with self.session:
            self._take_all()
            held = self._finish()
        changes = scale_range.changes(self.max_mg, self.interval_mg, now)
        if changes:
            apply_settings(self.balance.link, changes)
            self.balance.obey(SaveSettings())
        saved = self.balance.wait_saved()
        self.talk.tell(
            f"Calibrated: {len(held)} points, Max {self._mass(self.max_mg)}, "
            f"e {self._mass(self.interval_mg)}; saved, and read back.",
            tone="good",
        )
        return Outcome(held, self.max_mg, self.interval_mg, saved, self._check(held))

    # What the scale is to be.

    def _tell_what_is(self, now: dict[str, int]) -> None:
        max_mg, interval_mg = now["scale.max_mg"], now["scale.interval_mg"]
        self.talk.tell(
            f"Until now: Max {show_mass(max_mg, interval_mg)}, e {show_mass(interval_mg)}, "
            f"{len(self._old_points)} points"
            f"{' as the factory set them' if self._is_factory else ''}.",
            tone="soft",
        )

    @property
    def _is_factory(self) -> bool:
        factory = scale_design.config()
        pairs = zip(factory["point_counts_q7"], factory["point_mass_mg"], strict=True)
        held = [(one.counts_q7, one.mass_mg) for one in self._old_points]
        return held == list(pairs)[: factory["points"]]

    def _agree_range(self, now: dict[str, int]) -> None:
        def max_why_not(max_mg: int) -> str:
            if max_mg < MAX_LEAST_MG:
                return f"Max is {MAX_LEAST_MG} mg at least"
            return scale_range.why_not(max_mg, scale_range.usual_interval_mg(max_mg))

        def interval_why_not(interval_mg: int) -> str:
            return scale_range.why_not(self.max_mg, interval_mg)

        self.max_mg = self._agree(
            self.plan.max_mg, "Max, the greatest load?", now["scale.max_mg"], max_why_not
        )
        default_mg = now["scale.interval_mg"]
        if interval_why_not(default_mg) or self.max_mg != now["scale.max_mg"]:
            default_mg = scale_range.usual_interval_mg(self.max_mg)
        if self.plan.interval_mg is None and not self.plan.asks and self.plan.max_mg is None:
            default_mg = now["scale.interval_mg"]  # neither was given: nothing is to change
        self.interval_mg = self._agree(
            self.plan.interval_mg,
            "e, the least difference that counts?",
            default_mg,
            interval_why_not,
        )

    def _agree(self, given: int | None, question: str, default: int, why_not) -> int:
        """A mass that was given, or is asked for."""
        if given is None and self.plan.asks:
            return self.talk.ask_mass(question, default, why_not)
        value = default if given is None else given
        if why := why_not(value):
            raise UsageError(why)
        return value

    # Points.

    def _take_all(self) -> None:
        if self.plan.masses_mg is not None:
            for mass_mg in self.plan.masses_mg:
                self._point(mass_mg)
            return
        count = self.talk.ask_count(
            "How many points, the empty scale included? 2 do; 3 to 5 take the cell's bend off.",
            POINTS_USUAL,
            2,
            judge.POINTS_MAX,
        )
        self._point(0)
        for index in range(1, count):
            default_mg = round(self.max_mg * index / (count - 1))
            self._point(self._ask_point_mass(f"Mass of point {index + 1} of {count}?", default_mg))

    def _point(self, mass_mg: int) -> None:
        """One point, from the request to put it on until it is taken and believed."""
        while True:
            others = [one for one in self.session.points if one.mass_mg != mass_mg]
            if finding := judge.refuse_mass(others, mass_mg, self.interval_mg):
                self._refuse(finding)
                mass_mg = self._ask_point_mass("Another mass?", mass_mg)
                continue
            try:
                point = self._load_and_take(mass_mg)
            except CommandRefused as refused:
                if not self.plan.asks:
                    raise
                self.talk.tell_error(refused)
                self.talk.choose("Go on?", {"again": "try it again", "abort": ABORT})
                continue
            finding = judge.examine(
                others, point, interval_mg=self.interval_mg, before_mg=self._before_mg(point)
            )
            counts = counts_from_q7(point.counts_q7)
            if finding is None:
                self.talk.tell(f"Taken: {self._mass(mass_mg)} at {counts:.1f} counts.", tone="good")
                return
            mass_mg = self._settle(finding, point, others)
            if mass_mg is None:
                return

    def _load_and_take(self, mass_mg: int) -> Point:
        words = f"Put {self._mass(mass_mg)} on" if mass_mg else "Take everything off"
        if self.plan.asks:
            self.talk.put_on(words)
        else:
            self.talk.tell(f"{words}.")
        try:
            self._wait_for_change(CHANGED_WAIT_S if self.plan.asks else self.plan.wait_s)
            point = self.session.take(mass_mg, self.plan.wait_s, self.talk.show)
        finally:
            self.terminal.live("")
        if self.balance.weight is not None:
            self._last_net_mg = self.balance.weight.net_mg
        return point

    def _wait_for_change(self, patience_s: float) -> None:
        """What was there for the point before must be gone, or its weight would be taken again."""
        end_s = self.balance.link.now_s() + patience_s
        while self._last_net_mg is not None:
            self.balance.follow()
            self.talk.show(self.balance)
            weight = self.balance.weight
            if weight and abs(weight.net_mg - self._last_net_mg) > self._changed_mg:
                return
            if self.balance.link.now_s() >= end_s:
                if self.plan.asks:
                    return
                raise CalibrationRefused(
                    f"nothing was put on or taken off within {patience_s:g} s",
                    remedy="Give it longer with --wait.",
                )

    def _before_mg(self, point: Point) -> float | None:
        """What the old calibration says of the load since the first point."""
        if len(self._old_points) < 2 or self._is_factory:
            return None
        old = [(counts_from_q7(one.counts_q7), one.mass_mg) for one in self._old_points]
        says_mg = float(curve_mass_mg(counts_from_q7(point.counts_q7), old))
        if len(self.session.points) <= 1:
            self._empty_mg = says_mg - point.mass_mg
        return says_mg - self._empty_mg

    def _refuse(self, finding: judge.Finding) -> None:
        if not self.plan.asks:
            raise CalibrationRefused(finding.text, remedy=finding.remedy)
        self.talk.tell_error(finding, tone="bad" if finding.is_refusal else "warn")

    def _settle(self, finding: judge.Finding, point: Point, others: list[Point]) -> int | None:
        """What becomes of a point with something against it: the mass to try, or None: kept."""
        if self.plan.takes_doubtful and not finding.is_refusal:
            self.talk.tell_error(finding, tone="warn")
            return None
        self._refuse(finding)
        choices = {"again": "put it on again", "mass": "enter another mass for it"}
        if not finding.is_refusal:
            choices["keep"] = "keep it as it is"
        chosen = self.talk.choose("What now?", choices | {"abort": ABORT})
        if chosen == "keep":
            return None
        self.session.keep(others)
        self._last_net_mg = None  # the same load may be meant to stay
        if chosen == "again":
            return point.mass_mg
        return self._ask_point_mass("What lies there really?", point.mass_mg)

    # The end.

    def _finish(self) -> list[Point]:
        """Show what there is, have it agreed to, and let the device weigh by it."""
        while True:
            self._show_residuals()
            if self.plan.asks and not self._agreed():
                continue
            try:
                return self.session.end()
            except CommandRefused as refused:
                if not self.plan.asks:
                    raise CalibrationRefused(str(refused), remedy=refused.remedy) from refused
                self.talk.tell_error(refused)

    def _agreed(self) -> bool:
        points = self.session.points
        choices = {"save": "weigh by these points"} if len(points) >= 2 else {}
        choices |= {"again": "take one of them again", "add": "take one more", "abort": ABORT}
        chosen = self.talk.choose("What now?", choices)
        if chosen == "again":
            self._last_net_mg = None
            names = {str(n): self._mass(one.mass_mg) for n, one in enumerate(points, 1)}
            self._point(points[int(self.talk.choose("Which one?", names)) - 1].mass_mg)
        if chosen == "add":
            default_mg = round(judge.check_mass_mg(points)) if len(points) >= 2 else self.max_mg
            self._point(self._ask_point_mass("Its mass?", default_mg))
        return chosen == "save"

    def _show_residuals(self) -> None:
        points = self.session.points
        if len(points) < 2:
            return
        span_mg, found = judge.span_mg(points), judge.residuals(points)
        headings = ("mass", "counts", "a straight line says", "off by", "of the span")
        rows = [
            (
                self._mass(one.point.mass_mg),
                f"{counts_from_q7(one.point.counts_q7):.1f}",
                self._mass(one.line_mg),
                f"{one.off_mg / self.interval_mg:+.2f} e",
                f"{one.share(span_mg):+.3%}",
            )
            for one in found
        ]
        self.terminal.table(headings, rows)
        slope, _origin_mg = judge.line_through(points)
        way = ", falling" if slope < 0 else ""
        self.talk.tell(f"{abs(slope) * 1000:.1f} ug a count{way}.", tone="soft")
        if len(points) > 2:
            bend = max(abs(one.share(span_mg)) for one in found)
            self.talk.tell(
                f"The cell bends by {bend:.3%}; the curve through the points takes it off."
            )
        if warning := judge.reach_warning(points, self.max_mg, self.interval_mg):
            self.talk.tell(warning[0].upper() + warning[1:], tone="warn")

    def _check(self, held: list[Point]) -> int | None:
        if self.plan.asks:
            return check(self.talk, held, self.interval_mg, self.plan.wait_s)
        self.talk.tell(suggestion(held, self.interval_mg), tone="soft")
        return None

    # Small things.

    def _mass(self, mass_mg: float) -> str:
        return show_mass(mass_mg, self.interval_mg)

    def _ask_point_mass(self, question: str, default_mg: int) -> int:
        def why_not(mass_mg: int) -> str:
            finding = judge.refuse_mass(self.session.points, mass_mg, self.interval_mg)
            return finding.text if finding else ""

        return self.talk.ask_mass(question, default_mg, why_not)
