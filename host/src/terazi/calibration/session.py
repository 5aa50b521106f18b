# SPDX-License-Identifier: MIT
"""One calibration on the device: begun, points taken, ended or forgotten, whatever gets lost.

Every step may be repeated: a second point of one mass replaces the first, and what is begun,
ended or forgotten already answers so. The device weighs by its old calibration until `end`.
"""

import contextlib
from collections.abc import Sequence

from terazi.control.balance import Balance, Show
from terazi.errors import CommandRefused, NoAnswer, TeraziError
from terazi.link.generated.messages import (
    CalibrateAbort,
    CalibrateBegin,
    CalibrateEnd,
    CalibrateKnown,
    CalibratePoint,
    Point,
    Result,
    WeightFlag,
)

BEYOND = WeightFlag.OVER | WeightFlag.UNDER


class Session:
    """Use it as a context manager: what is not ended is forgotten, by an exception too."""

    def __init__(self, balance: Balance) -> None:
        self.balance = balance
        self.points: list[Point] = []  # taken so far, in the order of mass
        self._is_open = False

    def __enter__(self) -> "Session":
        self.begin()
        return self

    def __exit__(self, *_exception) -> None:
        if self._is_open:
            # The link may be what failed: then the device forgets at its next reset.
            with contextlib.suppress(TeraziError):
                self.abort()

    def begin(self) -> None:
        """Begin; what another program left half-done is forgotten."""
        self._is_open = True
        try:
            self.balance.obey(CalibrateBegin())
        except CommandRefused as refused:
            if refused.result != Result.CALIBRATING:
                raise
            # Ours whose ACK was lost, or one that nobody ended.
            self.abort()
            self._is_open = True
            self.balance.obey(CalibrateBegin())
        self.points = []

    def take(self, mass_mg: int, wait_s: float, show: Show = lambda _balance: None) -> Point:
        """Have the device take what lies there, once it stands still, as a point of this mass.

        Raises CommandRefused: by how much it moves, which fault holds, or what the device says.
        """
        balance = self.balance
        end_s = balance.link.now_s() + wait_s
        while True:
            # By the old calibration the load may be beyond Max, and then is never marked stable:
            # the device itself knows better.
            weight = balance.weight
            if balance.is_stable or (weight is not None and weight.weight_flags & BEYOND):
                try:
                    point = balance.link.ask(CalibratePoint(mass_mg), Point, mass_mg=mass_mg)
                except CommandRefused as refused:
                    if refused.result != Result.NOT_STABLE:
                        raise
                else:
                    return self._note(point)
            if balance.link.now_s() >= end_s:
                raise balance.why_not_stable(wait_s)
            balance.follow()
            show(balance)

    def know(self, point: Point) -> Point:
        """Give the device a point that was taken before."""
        command = CalibrateKnown(point.counts_q7, point.mass_mg)
        return self._note(self.balance.link.ask(command, Point, mass_mg=point.mass_mg))

    def keep(self, points: Sequence[Point]) -> None:
        """Begin anew with these points: the device has no way to forget a single one."""
        self.abort()
        self.begin()
        for point in points:
            self.know(point)

    def end(self) -> list[Point]:
        """Weigh by the points from now on; gives them as the device holds them.

        Raises CommandRefused where the device refuses them, and then the calibration goes on;
        NoAnswer where what it holds thereafter is not what was taken.
        """
        balance = self.balance
        balance.link.command(CalibrateEnd(), done_before=Result.NOT_CALIBRATING)
        self._is_open = False
        held = balance.points()
        wanted = [(point.counts_q7, point.mass_mg) for point in self.points]
        if [(point.counts_q7, point.mass_mg) for point in held] != wanted:
            raise NoAnswer(
                f"{balance.link.name} holds other points than were taken",
                remedy="It may have been reset meanwhile. Calibrate again.",
            )
        return held

    def abort(self) -> None:
        """Forget the points; the old calibration holds on."""
        self.balance.link.command(CalibrateAbort(), done_before=Result.NOT_CALIBRATING)
        self._is_open = False

    def _note(self, point: Point) -> Point:
        kept = [one for one in self.points if one.mass_mg != point.mass_mg]
        self.points = sorted([*kept, point], key=lambda one: one.mass_mg)
        return point
