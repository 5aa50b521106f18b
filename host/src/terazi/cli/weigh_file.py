# SPDX-License-Identifier: MIT
"""`terazi weigh FILE`."""

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from terazi.cli.common import JsonOption, errors, out


def file(
    capture: Annotated[
        Path, typer.Argument(help="A capture that `terazi log` made.", show_default=False)
    ],
    load_g: Annotated[
        str | None,
        typer.Option(
            help="What lay on the scale, in gram, in any order: 0,500,1000. Without it nothing is "
            "known of errors, and equal readings are put together.",
            show_default=False,
        ),
    ] = None,
    truth: Annotated[
        Path | None,
        typer.Option(
            help="Instead, a CSV of what lay there when, with columns t_s and load_g.",
            show_default=False,
        ),
    ] = None,
    e_g: Annotated[
        float | None,
        typer.Option(help="e in gram; without it as the capture tells.", show_default=False),
    ] = None,
    page: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="The page to write; without it none.", show_default=False
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """What a scale read at each load, in e, beside the limits of class III.

    Put each load on for 3 s at least while `terazi log` records, up and then down again for
    hysteresis. Short for it: terazi weigh FILE.

    [dim]Examples:[/]  terazi weigh weights.terazi --load-g 0,500,1000,2000,5000
    terazi weigh weights.terazi --truth weights.csv -o weights.weigh.html
    """
    from terazi.errors import CannotRead, UsageError
    from terazi.recorder import load_recording

    if not capture.exists():
        from terazi.cli.weigh import VERBS

        verbs = ", ".join(verb for verb in VERBS if verb != "file")
        raise CannotRead(f"there is no file {capture}", remedy=f"Verbs of terazi weigh: {verbs}")
    if load_g is not None and truth is not None:
        raise UsageError("--load-g and --truth say the same thing: give one of them")
    if e_g is not None and not 0 < e_g < float("inf"):
        raise UsageError(f"e must be more than nothing, not {e_g:g} g")
    if page and page.resolve() in {path.resolve() for path in (capture, truth) if path}:
        raise UsageError(f"{page} would overwrite what the page is made of")
    loads_g = None if load_g is None else _loads(load_g)
    recording = load_recording(capture)
    with errors.status("working ..."):
        try:
            from terazi.applications.weighing.points import weigh_up
            from terazi.report.analysis import analyse
            from terazi.report.truth import load_truth
        except ModuleNotFoundError as error:
            raise UsageError(
                f"{error.name} is missing", remedy="Install it: pip install 'terazi[report]'"
            ) from error

        known = load_truth(truth) if truth else None
        analysis = analyse(recording, known)
        weighing = weigh_up(recording, analysis, loads_g, e_g)
        if page:
            from terazi.applications.weighing.page import write_weighing

            write_weighing(page, recording, analysis, weighing)
    if as_json:
        print(json.dumps(_plain(weighing)))
        return
    _show(weighing)
    if page:
        out.print(f"page  {page}", soft_wrap=True)


def _loads(text: str) -> list[float]:
    """Raises UsageError where one is no weight."""
    from math import isfinite

    from terazi.errors import UsageError

    try:
        loads_g = [float(word) for word in text.split(",")]
    except ValueError:
        loads_g = []
    if not loads_g or not all(isfinite(load) for load in loads_g):
        raise UsageError(
            f"--load-g {text} is no list of weights", remedy="For example: --load-g 0,500,1000"
        )
    return loads_g


def _plain(weighing) -> dict:
    import dataclasses
    import math

    def finite(value):
        if isinstance(value, dict):
            return {key: finite(each) for key, each in value.items()}
        if isinstance(value, list):
            return [finite(each) for each in value]
        return None if isinstance(value, float) and not math.isfinite(value) else value

    return finite(dataclasses.asdict(weighing) | {"within": weighing.within})


def _show(weighing) -> None:
    title = f"e = {weighing.e_g:g} g; converter's floor {weighing.floor_e:.3f} e a raw sample"
    table = Table(title=title)
    for heading in ("load", "n", "error", "worst", "class III", "sigma", "σ/√N", "repeat", "hyst."):
        table.add_column(heading, justify="right", no_wrap=True)
    for point in weighing.points:
        table.add_row(
            f"{point.load_g:g} g" if point.is_known else f"{point.load_g:.1f} g",
            str(point.placements),
            _e(point.mean_error_e, "+.3f"),
            _e(point.worst_error_e, ".3f"),
            f"±{point.limit_e:g}{_verdict(point)}",
            f"{point.sigma_e:.3f}",
            _e(point.bound_e, ".3f"),
            f"{point.repeatability_e:.3f}",
            _e(point.hysteresis_e, "+.3f"),
        )
    out.print(table)
    out.print(
        "All in e. ok: within the limits of verification; serv.: within twice those, in service. "
        "hyst.: coming down less going up.",
        style="dim",
    )
    unstable = [one for one in weighing.placements if not one.is_stable]
    if unstable:
        times = ", ".join(f"{one.t_s:.1f} s" for one in unstable)
        out.print(f"never stable, read when settled: at {times}")


def _e(value: float | None, form: str) -> str:
    import math

    return "-" if value is None or not math.isfinite(value) else format(value, form)


def _verdict(point) -> str:
    """Beside the limit of verification; in service it is twice that."""
    if point.within is None:
        return ""
    return (
        " ok"
        if point.within
        else " [yellow]serv.[/]"
        if point.within_in_service
        else " [red]out[/]"
    )
