# SPDX-License-Identifier: MIT
"""`terazi attitude score`."""

import json
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from terazi.cli.common import JsonOption, errors, out


class Mode(StrEnum):
    """Sensors by the number of their axes."""

    six = "6"
    nine = "9"


class Filter(StrEnum):
    """How acceleration corrects; mahony.h."""

    second_order = "second_order"
    linear = "linear"
    classic = "classic"


def score(
    folder: Annotated[
        Path,
        typer.Argument(help="Folder of .npz trials in BROAD's format, or one.", show_default=False),
    ],
    mode: Annotated[
        Mode, typer.Option(help="6: gyroscope and accelerometer. 9: and magnetometer.")
    ] = Mode.six,
    filter_: Annotated[
        Filter, typer.Option("--filter", help="How acceleration corrects the inclination.")
    ] = Filter.second_order,
    as_json: JsonOption = False,
) -> None:
    """Run the chip's own filter over trials whose orientation is known, and tell its errors.

    Fixed point as shipped, causal, start-up included, one setting for all trials. Root mean square
    over the samples that move and have a truth. With 6 axes heading is free: the one constant
    turn about the vertical that fits best is taken off each trial, so that heading and total say
    how it drifts; with 9 axes nothing is taken off.

    [dim]Examples:[/]  terazi attitude score broad/
    terazi attitude score broad/ --mode 9 --json
    """
    from rich.progress import track

    from terazi.applications import attitude as application

    paths = application.find_trials(folder)
    trials = (
        application.load_trial(path)
        for path in track(paths, "working ...", console=errors, transient=True)
    )
    result = application.score(
        trials,
        lambda trial: application.estimate(trial, mode=int(mode), filter=filter_.value),
        heading_is_free=mode is Mode.six,
    )
    if as_json:
        print(json.dumps(result.plain()))
    else:
        _show(result, mode, filter_)


def _show(result, mode: Mode, filter_: Filter) -> None:
    table = Table("trial", title=f"{mode} axes, {filter_}: root mean square in degrees")
    for heading in ("inclination", "heading", "total"):
        table.add_column(heading, justify="right")
    plain = result.plain()
    for name, row in plain["trials"].items():
        table.add_row(name, *(f"{value:.2f}" for value in row.values()))
    table.add_section()
    for name in ("mean", "worst"):
        table.add_row(name, *(f"{value:.3f}" for value in plain[name].values()))
    out.print(table)
    if mode is Mode.six:
        out.print("Six axes know no north: a constant heading is taken off each trial.")
