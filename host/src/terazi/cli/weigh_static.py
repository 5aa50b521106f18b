# SPDX-License-Identifier: MIT
"""`terazi weigh static`."""

import json
from typing import Annotated

import typer
from rich.table import Table

from terazi.cli.common import JsonOption, errors, out


def static(
    seed: Annotated[int, typer.Option(help="Of all noise.", min=0)] = 2026,
    repeats: Annotated[int, typer.Option(help="Of each step and each rate.", min=1)] = 20,
    as_json: JsonOption = False,
) -> None:
    """How true and how soon the scale is: errors beside class III, time until stable.

    The chip's own chain behind a simulated 5 kg cell of e = 1 g that bows by 0.02 %, in the
    converter's noise: calibrated with two and with five points; steps from 2 e to full range;
    loads that creep, sway and run, while which no flag may stand that is off by more than 1 e.

    [dim]Examples:[/]  terazi weigh static
    terazi weigh static --repeats 5 --json
    """
    from terazi.applications.weighing.accuracy import AccuracyExperiment, accuracy
    from terazi.applications.weighing.stability import StabilityExperiment, stability

    with errors.status("working ...") as status:

        def progress(what: str) -> None:
            status.update(f"{what} ...")

        result = {
            "accuracy": accuracy(AccuracyExperiment(seed=seed), progress),
            "stability": stability(StabilityExperiment(seed=seed, repeats=repeats), progress),
        }
    if as_json:
        print(json.dumps(result))
        return
    _show_accuracy(result["accuracy"])
    _show_steps(result["stability"])
    _show_moving(result["stability"])


def _show_accuracy(found: dict) -> None:
    table = Table("load", title="Error in e, worst of all repeats, up and down")
    for points in found["by_points"]:
        table.add_column(f"{points} points", justify="right")
    table.add_column("class III", justify="right")
    columns = [each["per_load"] for each in found["by_points"].values()]
    for load, one in columns[0].items():
        worst = [f"{column[load]['worst_e']:.3f}" for column in columns]
        table.add_row(f"{load} e", *worst, f"{one['limit_e']:g}")
    out.print(table)


def _show_steps(found: dict) -> None:
    table = Table("step", title="Seconds from the step until stable, worst of all rates")
    for name in found["steps"]:
        table.add_column(name, justify="right")
    columns = list(found["steps"].values())
    for step in columns[0]:
        table.add_row(step, *(f"{column[step]['worst_s']:.3f}" for column in columns))
    out.print(table)
    late = max(each["late_samples"] for column in columns for each in column.values())
    out.print(f"The flag fell within {late} samples of each step.")


def _show_moving(found: dict) -> None:
    table = Table("load", title="Loads that move, while the flag stands")
    for heading in ("stable", "off the truth", "truth moved"):
        table.add_column(heading, justify="right")
    for name, each in found["moving"].items():
        table.add_row(
            name,
            f"{each['stable_share'] * 100:.1f} %",
            f"{each['off_e']:.2f} e",
            f"{each['moved_e']:.2f} e",
        )
    out.print(table)
