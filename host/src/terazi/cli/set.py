# SPDX-License-Identifier: MIT
"""`terazi set`."""

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table
from rich.text import Text

from terazi.cli.board import board
from terazi.cli.common import BAUD_DEFAULT, PORT_REST_S, BaudOption, JsonOption, errors, out

UART_BAUD = "uart.baud"
SENSORS = ("acc", "gyro", "mag")


def set(
    words: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[PORT] [NAME=VALUE ...]",
            help="The port, unless TERAZI_PORT or the only board says it; settings to be set, as "
            "max=5kg or checkweigher.on=true; a NAME alone shows it.",
            show_default=False,
        ),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="Show all settings.")] = False,
    export: Annotated[
        Path | None,
        typer.Option(help="Write all settings as TOML; - for standard output.", show_default=False),
    ] = None,
    import_: Annotated[
        Path | None,
        typer.Option(
            "--import",
            help="Take settings from a TOML file, the calibration too.",
            show_default=False,
        ),
    ] = None,
    reset: Annotated[
        bool, typer.Option("--reset", help="Back to the factory's, but for the calibration.")
    ] = False,
    everything: Annotated[
        bool, typer.Option("--everything", help="With --reset: the calibration, too.")
    ] = False,
    no_save: Annotated[
        bool, typer.Option("--no-save", help="Only until the next reset: leave EEPROM as it is.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file of --export.")] = False,
    baud: BaudOption = BAUD_DEFAULT,
    as_json: JsonOption = False,
) -> None:
    """Show and change what outlives a reset: Max, display, filters, checkweigher. Resets the board.

    Values bear units or are in the setting's own. Either all that is given holds, or nothing. With
    a new uart.baud the board starts anew, and is looked for at that rate.

    [dim]Examples:[/]  terazi set --list      terazi set max=5kg e=1g unit=kg decimals=3
    terazi set uart.baud=500000      terazi set --export scale.toml
    """
    from terazi.control import Balance
    from terazi.control.setting_text import find_setting, parse_value
    from terazi.errors import UsageError

    if everything and not reset:
        raise UsageError("--everything belongs to --reset")
    port, assignments, names = _sorted_words(words or [])
    wanted = {}
    for name, text in assignments:
        setting = find_setting(name)
        wanted[setting.full_name] = parse_value(setting, text)
    asked = [find_setting(name) for name in names]
    if sum(map(bool, (wanted, export, import_, reset))) > 1:
        raise UsageError("give one of NAME=VALUE, --export, --import and --reset")
    if export and str(export) != "-" and export.exists() and not force:
        from terazi.recorder.files import cannot_write

        raise cannot_write(export, FileExistsError())
    file = None
    if import_:
        from terazi.settings import read_settings_file

        file = read_settings_file(import_)
    new_baud = (file.settings if file else wanted).get(UART_BAUD)
    if no_save and new_baud is not None:
        raise UsageError(f"{UART_BAUD} holds from the next start on: it goes without --no-save")
    with board(port, baud) as link:
        balance = Balance(link)
        balance.quiet_stream()  # a line that is full of attitudes has no room for answers
        if export:
            _export(link, export)
        elif wanted:
            _apply(balance, wanted, no_save, as_json)
        elif file is not None:
            _import(balance, file, no_save, as_json)
        elif reset:
            _reset(balance, everything, no_save)
        if asked or list_ or not (wanted or export or import_ or reset):
            _list(link, asked, as_json)
        name, old_baud = link.name, link.baud
    if reset:
        new_baud = _default_baud()
    if new_baud is not None and old_baud is not None:
        _restart(name, old_baud, new_baud, as_json)


def _default_baud() -> int:
    from terazi.control.setting_text import find_setting

    return find_setting(UART_BAUD).default


def _restart(port: str, old_baud: int, new_baud: int, as_json: bool) -> None:
    """Let the board begin anew where it has to speak at another rate, and find it there.

    new_baud : as the setting has it.
    """
    import time

    from terazi.link import BAUDS

    wanted = BAUDS[new_baud]
    if wanted == old_baud:
        return
    time.sleep(PORT_REST_S)
    with board(port, None) as link:
        found = link.baud
    if found != wanted:
        errors.print(
            f"It still speaks {found} baud: opening its port does not reset it. Press its button.",
            style="yellow",
            soft_wrap=True,
        )
    elif not as_json:
        out.print(f"restarted: it speaks {found} baud now", style="green")


def _sorted_words(words: list[str]) -> tuple[str | None, list[tuple[str, str]], list[str]]:
    """(port, [(name, value)], names to be shown). Only the first word can be a port."""
    import os

    from terazi.control.setting_text import find_setting
    from terazi.errors import UsageError

    port, assignments, names = os.environ.get("TERAZI_PORT") or None, [], []
    for index, word in enumerate(words):
        name, is_assignment, value = word.partition("=")
        if is_assignment and "/" not in name:
            assignments.append((name, value))
            continue
        try:
            find_setting(word)
            names.append(word)
        except UsageError:
            if index or not _looks_like_port(word):
                raise
            port = word
    return port, assignments, names


def _looks_like_port(word: str) -> bool:
    """A path, or COM3."""
    return "/" in word or "\\" in word or word.upper().startswith("COM") or Path(word).exists()


def _apply(balance, wanted: dict[str, int], no_save: bool, as_json: bool) -> None:
    from terazi.control.settings import apply_settings

    wanted = _with_followers(balance.link, wanted)
    before = apply_settings(balance.link, wanted)
    _save(balance, no_save)
    if as_json:
        changes = {
            name: {"before": before.get(name, value), "now": value}
            for name, value in wanted.items()
        }
        print(json.dumps(changes))
        return
    for name, value in wanted.items():
        _show_change(name, before.get(name, value), value)
    _show_saved(no_save)


def _with_followers(link, wanted: dict[str, int]) -> dict[str, int]:
    """With a new Max or e goes what is told in e, unless it is set by itself."""
    from terazi.calibration.range import RANGE_SETTINGS, changes, why_not
    from terazi.control.settings import read_settings
    from terazi.errors import UsageError

    if not wanted.keys() & {"scale.max_mg", "scale.interval_mg"}:
        return wanted
    now = read_settings(link, RANGE_SETTINGS)
    max_mg = wanted.get("scale.max_mg", now["scale.max_mg"])
    interval_mg = wanted.get("scale.interval_mg", now["scale.interval_mg"])
    if reason := why_not(max_mg, interval_mg):
        raise UsageError(reason)
    return wanted | {
        name: value
        for name, value in changes(max_mg, interval_mg, now).items()
        if name not in wanted
    }


def _export(link, path: Path) -> None:
    from datetime import UTC, datetime

    from terazi.cli.common import show_version
    from terazi.recorder.files import cannot_write
    from terazi.settings import read_device, render_settings

    when = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    heading = [f"Terazi {show_version(link.hello())} at {link.name}, {when}."]
    text = render_settings(read_device(link), heading)
    if str(path) == "-":
        print(text, end="")
        return
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise cannot_write(path, error) from error
    out.print(f"wrote {path}", soft_wrap=True)


def _import(balance, file, no_save: bool, as_json: bool) -> None:
    from terazi.errors import UsageError
    from terazi.settings import apply_file, differences, read_device

    changes = differences(read_device(balance.link), file)
    if no_save and any(change.name == "calibration.points" for change in changes):
        raise UsageError(
            "a calibration saves itself, and the settings with it: it goes without --no-save"
        )
    changes = apply_file(balance, file)
    if changes:
        _save(balance, no_save)
    if as_json:
        words = {change.name: {"before": change.before, "now": change.now} for change in changes}
        print(json.dumps(words))
        return
    for change in changes:
        out.print(f"{change.name}  {change.before} -> {change.now}", markup=False, soft_wrap=True)
    if changes:
        _show_saved(no_save)
    else:
        out.print("nothing to change: the board holds it all")


def _show_change(name: str, before: int, now: int) -> None:
    from terazi.control.setting_text import find_setting, show_with_unit

    setting = find_setting(name)
    old, new = show_with_unit(setting, before), show_with_unit(setting, now)
    words = f"{name}  {new}, as it was" if before == now else f"{name}  {old} -> {new}"
    out.print(words, markup=False, soft_wrap=True)


def _save(balance, no_save: bool) -> None:
    from terazi.link.generated.messages import SaveSettings

    if not no_save:
        balance.obey(SaveSettings())
        balance.wait_saved()


def _show_saved(no_save: bool) -> None:
    out.print(
        "not saved: it holds until the next reset" if no_save else "saved",
        style="yellow" if no_save else "green",
    )


def _reset(balance, everything: bool, no_save: bool) -> None:
    from terazi.errors import UsageError
    from terazi.link.generated.messages import ResetSettings, ResetWhat

    if no_save:
        raise UsageError("--reset is written at once; it goes without --no-save")
    what = ResetWhat.EVERYTHING if everything else ResetWhat.ALL_BUT_CALIBRATION
    balance.obey(ResetSettings(what))
    balance.wait_saved()
    out.print(f"factory settings, {'all' if everything else 'but for the calibration'}; saved")
    if everything:
        errors.print("The scale wants calibrating: `terazi calibrate`.", style="yellow")


def _list(link, asked: list, as_json: bool) -> None:
    from terazi.control.setting_text import allowed, show_with_unit
    from terazi.control.settings import read_settings
    from terazi.link.generated.settings import SETTINGS

    shown = asked or SETTINGS
    values = read_settings(link, [one.full_name for one in shown])
    if as_json:
        print(json.dumps(values))
        return
    if asked:
        for one in asked:
            out.print(
                f"{one.full_name}  {show_with_unit(one, values[one.full_name])}", markup=False
            )
            out.print(f"  {one.summary}", markup=False)
            out.print(f"  {allowed(one)}; factory: {show_with_unit(one, one.default)}", style="dim")
        return
    table = Table(show_header=False, box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for column in ("setting", "value"):
        table.add_column(column, no_wrap=True)
    table.add_column("summary")  # gives way where the terminal is narrow
    for one in shown:
        if not _is_idle(one, values):
            value = values[one.full_name]
            style = "" if value == one.default else "bold"
            words = Text(show_with_unit(one, value), style=style)
            summary = Text(one.summary, style="dim", no_wrap=True, overflow="ellipsis")
            table.add_row(one.full_name, words, summary)
    out.print(table)
    out.print("bold: not as it left the factory; `terazi set NAME` tells more", style="dim")


def _is_idle(setting, values: dict[str, int]) -> bool:
    """Whether this is of a point or class beyond those that there are, or of a sensor that was
    never calibrated."""
    if setting.group in SENSORS and setting.name != "orientation":
        return not any(
            value
            for name, value in values.items()
            if name.startswith(f"{setting.group}.") and not name.endswith(".orientation")
        )
    limits = {
        "checkweigher": values["checkweigher.classes"] - 1,
        "calibration": values["calibration.points"],
    }
    number = setting.name.rpartition("_")[2]
    return number.isdecimal() and int(number) >= limits.get(setting.group, int(number) + 1)
