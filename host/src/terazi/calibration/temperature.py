# SPDX-License-Identifier: MIT
"""A recorded temperature run: what zero and span drift by, fitted, shown, and set on consent.

The scale stands empty, then with one and the same mass on, and each time warms or cools by some
kelvin; beside the thermometer raw counts are recorded, a mean a second. The device does not
correct meanwhile. terazi.applications.weighing.temperature makes the coefficients.
"""

import contextlib
import csv
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from terazi.applications.weighing import temperature as drifts
from terazi.calibration.talk import ABORT, Talk
from terazi.calibration.terminal import Terminal
from terazi.control.balance import Balance
from terazi.control.display import temperature_deg_c
from terazi.control.settings import apply_settings, read_settings
from terazi.design.temperature import limits
from terazi.errors import CalibrationRefused, TeraziError
from terazi.link import Received
from terazi.link.generated.messages import Sample, SampleFlag, SaveSettings, SetStream, StreamFlag
from terazi.recorder.files import cannot_write

GROUP = "temperature"
MEAN_S = 1.0
TURN_S = 0.25
THERMOMETER_S = 3.0  # after a start it has answered by then, or there is none
SERIES = ("with nothing on", "with the mass on")
COLUMNS = ("series", "device_s", "temperature_c", "raw_counts", "samples")


@dataclass(frozen=True)
class Plan:
    """span_k: how far the temperature is to move in each series, where nobody presses Enter."""

    asks: bool = True
    with_mass: bool = True
    span_k: float = 10.0
    longest_s: float = 4 * 3600.0  # of a series
    output: Path | None = None  # CSV of the run


@dataclass
class Series:
    """Means of MEAN_S each."""

    name: str
    device_s: list[float] = field(default_factory=list)
    temperature_c: list[float] = field(default_factory=list)
    raw_counts: list[float] = field(default_factory=list)

    @property
    def moved_k(self) -> float:
        return max(self.temperature_c) - min(self.temperature_c) if self.temperature_c else 0.0


def calibrate_temperature(
    balance: Balance, terminal: Terminal, plan: Plan
) -> drifts.TemperatureFit | None:
    """The whole run; gives what was set, None where it was not wanted.

    Raises CalibrationRefused where the run says nothing, and what the link raises. Unless it ends
    with consent, compensation is as it was.
    """
    return _Run(balance, terminal, plan).run()


class _Run:
    def __init__(self, balance: Balance, terminal: Terminal, plan: Plan) -> None:
        self.balance, self.terminal, self.plan = balance, terminal, plan
        self.talk = Talk(balance, terminal)
        self.series: list[Series] = []
        self._rows = None

    def run(self) -> drifts.TemperatureFit | None:
        link = self.balance.link
        self._want_thermometer()
        link.command(SetStream(mask=StreamFlag.SAMPLE | StreamFlag.WEIGHT | StreamFlag.EVENT))
        before = apply_settings(link, {f"{GROUP}.on": 0})
        try:
            fit = self._record_and_fit()
            wanted = {f"{GROUP}.{name}": value for name, value in fit.settings.items()}
            self._show(fit)
            if not self._agreed(fit):
                apply_settings(link, before)
                return None
            apply_settings(link, wanted | {f"{GROUP}.on": 1})
        except BaseException:
            with contextlib.suppress(TeraziError):  # the link may be what failed
                apply_settings(link, before)
            raise
        self.balance.obey(SaveSettings())
        self.balance.wait_saved()
        self._verify(wanted)
        return fit

    def _want_thermometer(self) -> None:
        self.balance.follow(THERMOMETER_S)
        weight = self.balance.weight
        if weight is None or temperature_deg_c(weight) is None:
            raise CalibrationRefused(
                "the board has no thermometer: nothing answers as an MPU6050",
                remedy="Wire one: VCC at 5V, GND, SDA at A4, SCL at A5.",
            )

    def _record_and_fit(self) -> drifts.TemperatureFit:
        with _Table(self.plan.output) as table:
            self._record(SERIES[0], "Take everything off", table)
            if self.plan.with_mass:
                what = "Put one mass on, a quarter of Max or more, and let it lie"
                self._record(SERIES[1], what, table)
        columns = [column for one in self.series for column in (one.temperature_c, one.raw_counts)]
        try:
            return drifts.fit(*columns)
        except drifts.TemperatureRunRefused as refused:
            raise CalibrationRefused(str(refused), remedy=refused.remedy) from refused

    def _record(self, name: str, what: str, table: "_Table") -> None:
        if self.plan.asks:
            self.talk.put_on(what)
        else:
            self.talk.tell(f"{what}.")
        self.balance.wait_stable(30.0, self.talk.show)
        self.terminal.live("")
        series = Series(name)
        self.series.append(series)
        mean = _Mean(self.balance, series, table)
        self.balance.on_received = mean.take
        least_k = limits()["moved_min_k"]

        def turn() -> str:
            self.balance.follow(TURN_S)
            now = series.temperature_c[-1:] or [float("nan")]
            return (
                f"{now[0]:.2f} °C, moved by {series.moved_k:.2f} K of {least_k:g} K at least, "
                f"{len(series.device_s)} s recorded"
            )

        try:
            if self.plan.asks:
                self.terminal.pause(
                    "Recording. Warm or cool the scale slowly, one way all the time; Enter when it "
                    "has moved enough.",
                    turn,
                )
            else:
                self._until_moved(series, turn)
        finally:
            self.balance.on_received = lambda _received: None
            self.terminal.live("")
        self.talk.tell(
            f"Recorded {name}: {len(series.device_s)} s, {series.moved_k:.2f} K.", tone="good"
        )

    def _until_moved(self, series: Series, turn: Callable[[], str]) -> None:
        end_s = self.balance.link.now_s() + self.plan.longest_s
        while series.moved_k < self.plan.span_k and self.balance.link.now_s() < end_s:
            self.terminal.live(turn())

    def _show(self, fit: drifts.TemperatureFit) -> None:
        self.talk.tell(
            f"Zero drifts by {fit.zero_counts_per_k:+.2f} counts a kelvin, span by "
            f"{fit.span_ppm_per_k:+.1f} ppm a kelvin; all is corrected to {fit.reference_c:.2f} °C."
        )
        named = zip(SERIES, (fit.empty, fit.loaded), strict=True)
        rows = [
            (
                name,
                f"{left.before_rms:.1f}",
                f"{left.after_rms:.1f}",
                f"{left.before_span:.0f}",
                f"{left.after_span:.0f}",
            )
            for name, left in named
            if left is not None
        ]
        headings = ("counts", "rms before", "rms after", "span before", "span after")
        self.terminal.table(headings, rows)

    def _agreed(self, fit: drifts.TemperatureFit) -> bool:
        if not fit.helps:
            raise CalibrationRefused(
                "the correction would leave more than there was: nothing is set",
                remedy="Let the scale warm through slowly, so that cell and thermometer agree.",
            )
        if not self.plan.asks:
            return True
        choices = {"save": "correct by this from now on", "leave": "leave the board as it is"}
        return self.talk.choose("What now?", choices | {"abort": ABORT}) == "save"

    def _verify(self, wanted: dict[str, int]) -> None:
        held = read_settings(self.balance.link, wanted)
        if held != wanted:
            raise TeraziError(f"{self.balance.link.name} holds other coefficients than were set")
        self.talk.tell("Temperature compensation is on; saved, and read back.", tone="good")


class _Mean:
    """Raw counts and temperature, a mean each second; samples after a fault do not count."""

    def __init__(self, balance: Balance, series: Series, table: "_Table") -> None:
        self._balance, self._series, self._table = balance, series, table
        self._counts: list[int] = []
        self._degrees: list[float] = []
        self._begin_us: int | None = None

    def take(self, received: Received) -> None:
        message = received.message
        if not isinstance(message, Sample) or self._balance.weight is None:
            return
        degrees = temperature_deg_c(self._balance.weight)
        if degrees is None or message.flags & (SampleFlag.AT_RAIL | SampleFlag.GAP):
            return
        if self._begin_us is None:
            self._begin_us = received.device_us
        self._counts.append(message.raw_counts)
        self._degrees.append(degrees)
        if received.device_us - self._begin_us >= MEAN_S * 1e6:
            self._end(received.device_us)

    def _end(self, device_us: int) -> None:
        row = (device_us / 1e6, float(np.mean(self._degrees)), float(np.mean(self._counts)))
        for column, value in zip(
            (self._series.device_s, self._series.temperature_c, self._series.raw_counts),
            row,
            strict=True,
        ):
            column.append(value)
        self._table.write(self._series.name, *row, len(self._counts))
        self._counts, self._degrees, self._begin_us = [], [], None


class _Table:
    """The run as CSV, line by line, so that nothing is lost with an evening's work; or nothing."""

    def __init__(self, path: Path | None) -> None:
        self._path, self._file = path, None

    def __enter__(self) -> "_Table":
        if self._path is not None:
            try:
                self._file = open(self._path, "x", newline="", encoding="utf-8")
            except OSError as error:
                raise cannot_write(self._path, error) from error
            self._rows = csv.writer(self._file, lineterminator="\n")
            self._rows.writerow(COLUMNS)
        return self

    def write(self, series: str, device_s: float, degrees: float, counts: float, n: int) -> None:
        if self._file is not None:
            row = (series, f"{device_s:.3f}", f"{degrees:.3f}", f"{counts:.2f}", n)
            self._rows.writerow(row)
            self._file.flush()

    def __exit__(self, *_exception) -> None:
        if self._file is not None:
            self._file.close()
