# SPDX-License-Identifier: MIT
"""`terazi calibrate`."""

import dataclasses
import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from terazi.cli.board import board
from terazi.cli.calibrate_imu import Wish
from terazi.cli.calibrate_imu import run as run_imu
from terazi.cli.common import BAUD_DEFAULT, BaudOption, JsonOption, PortArgument, errors, out


def calibrate(
    port: PortArgument = None,
    mass: Annotated[
        list[str] | None,
        typer.Option(
            help="A point's mass, as 0, 500 or 0.5kg, in the order in which they are put on; "
            "several times. Without it, the dialogue asks.",
            show_default=False,
        ),
    ] = None,
    max_: Annotated[
        str | None,
        typer.Option("--max", help="Max, the greatest load, as 5kg.", show_default=False),
    ] = None,
    e: Annotated[
        str | None,
        typer.Option("--e", help="e, the least difference that counts, as 1g.", show_default=False),
    ] = None,
    yes: Annotated[
        bool,
        typer.Option(
            "--yes", help="Ask nothing: take points as the loads come, doubtful ones too."
        ),
    ] = False,
    wait: Annotated[
        float, typer.Option(help="Seconds to wait for a load, and until it stands.", min=0.0)
    ] = 30.0,
    temperature: Annotated[
        bool,
        typer.Option(
            "--temperature",
            help="Record how the scale drifts with its thermometer, and correct by it.",
        ),
    ] = False,
    no_mass: Annotated[
        bool, typer.Option("--no-mass", help="With --temperature: the zero's drift only.")
    ] = False,
    span: Annotated[
        float,
        typer.Option(help="With --temperature and --yes: record until it moved by so many kelvin."),
    ] = 10.0,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="With --temperature: the run as CSV.", show_default=False
        ),
    ] = None,
    imu: Annotated[
        bool,
        typer.Option(
            "--imu", help="The IMU: accelerometer from six sides and slants, gyroscope between."
        ),
    ] = False,
    mag: Annotated[
        bool, typer.Option("--mag", help="The magnetometer, alone or after --imu: turn it about.")
    ] = False,
    board_free: Annotated[
        bool,
        typer.Option(
            "--board-free",
            help="With --imu: twelve positions of any kind, for what has no sides to lie on.",
        ),
    ] = False,
    six_only: Annotated[
        bool, typer.Option("--six-only", help="With --imu: no slants; cross axes stay unknown.")
    ] = False,
    self_test: Annotated[
        bool, typer.Option("--self-test", help="The IMU's own test, beside its trim codes.")
    ] = False,
    source: Annotated[
        Path | None,
        typer.Option(
            "--from",
            help="With --imu or --mag: a recording of it, in place of a live board.",
            show_default=False,
        ),
    ] = None,
    dry_run: Annotated[
        bool,
        typer.Option("--dry-run", help="With --imu or --mag: show what would be set, set nothing."),
    ] = False,
    level: Annotated[
        bool,
        typer.Option(
            "--level", help="How the IMU stands on the board: lay it as it will stand in use."
        ),
    ] = False,
    rehearse: Annotated[
        int,
        typer.Option(
            help="With --imu: calibrate so many simulated boards of known errors; needs no board.",
            min=0,
            max=1000,
            show_default=False,
        ),
    ] = 0,
    abort: Annotated[
        bool, typer.Option("--abort", help="Forget a calibration that nobody ended.")
    ] = False,
    baud: BaudOption = BAUD_DEFAULT,
    as_json: JsonOption = False,
) -> None:
    """Calibrate the scale: it says what to put on, waits until it stands, and shows what came out.

    Until the end the scale weighs as before, and ctrl-C leaves it so. With --mass and without a
    terminal, or with --yes, nothing is asked: each load is taken when it is there and stands.
    With --imu, --mag, --level or --self-test it is about the IMU. Resets the board.

    [dim]Examples:[/]  terazi calibrate
    terazi calibrate --max 5kg --e 1g --mass 0 --mass 2kg --mass 5kg
    terazi calibrate --temperature -o warming.csv
    terazi calibrate --imu --mag
    terazi calibrate --imu --from sides.terazi --dry-run
    """
    from terazi.calibration import Plan
    from terazi.calibration import calibrate as run
    from terazi.cli.terminal import RichTerminal
    from terazi.control import Balance
    from terazi.control.quantities import parse_mass_mg
    from terazi.errors import UsageError

    asks = not yes and sys.stdin is not None and sys.stdin.isatty()
    wish = Wish(imu, mag, self_test, board_free, six_only, source, dry_run, rehearse, level)
    wish.check()
    if wish.is_any:
        if mass or max_ or e or temperature or abort:
            raise UsageError("the scale and the IMU are calibrated one after the other")
        if not asks and not yes and not (self_test or dry_run or rehearse):
            raise UsageError("nobody is there to ask", remedy="Give --yes to ask nothing.")
        run_imu(wish, port, baud, asks, wait, as_json)
        return
    if not temperature and (no_mass or output):
        raise UsageError("--no-mass and --output belong to --temperature")
    if temperature:
        if not asks and not yes:
            raise UsageError("nobody is there to ask", remedy="Give --yes to ask nothing.")
        _temperature(port, baud, asks, no_mass, span, output, as_json)
        return
    if not asks and not mass and not abort:
        raise UsageError(
            "nobody is there to ask: standard input is no terminal, or --yes was given",
            remedy="Name the masses: --mass 0 --mass 500g --mass 1kg",
        )
    if mass and len(mass) < 2:
        raise UsageError("a calibration needs two points or more", remedy="Add --mass 0.")
    plan = Plan(
        masses_mg=tuple(map(parse_mass_mg, mass)) if mass else None,
        max_mg=parse_mass_mg(max_) if max_ else None,
        interval_mg=parse_mass_mg(e) if e else None,
        wait_s=wait,
        asks=asks,
        takes_doubtful=yes,
    )
    with board(port, baud) as link:
        balance = Balance(link)
        if abort:
            _abort(balance)
            return
        outcome = run(balance, RichTerminal(errors if as_json else out), plan)
    if as_json:
        print(json.dumps(_plain(outcome)))


def _temperature(port, baud, asks, no_mass, span, output, as_json) -> None:
    from terazi.calibration.temperature import Plan, calibrate_temperature
    from terazi.cli.terminal import RichTerminal
    from terazi.control import Balance

    plan = Plan(asks=asks, with_mass=not no_mass, span_k=span, output=output)
    with board(port, baud) as link:
        terminal = RichTerminal(errors if as_json else out)
        fit = calibrate_temperature(Balance(link), terminal, plan)
    if as_json:
        print(json.dumps(None if fit is None else dataclasses.asdict(fit)))


def _abort(balance) -> None:
    from terazi.errors import CommandRefused
    from terazi.link.generated.messages import CalibrateAbort, Result

    try:
        balance.link.command(CalibrateAbort())
    except CommandRefused as refused:
        if refused.result != Result.NOT_CALIBRATING:
            raise
    out.print("no calibration is under way")


def _plain(outcome) -> dict:
    return {
        "points": [
            {"counts_q7": point.counts_q7, "mass_mg": point.mass_mg} for point in outcome.points
        ],
        "max_mg": outcome.max_mg,
        "interval_mg": outcome.interval_mg,
        "settings_saved": outcome.settings_saved,
        "check_off_mg": outcome.check_off_mg,
    }
