# SPDX-License-Identifier: MIT
"""`terazi attitude allan`."""

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from terazi.cli.common import JsonOption, errors, out

RecordingArgument = Annotated[
    Path,
    typer.Argument(
        help="A capture that `terazi log` made, or an .npz with gyr and acc in counts.",
        show_default=False,
    ),
]
BeginOption = Annotated[
    float | None, typer.Option(help="Leave out what is before, in seconds.", show_default=False)
]
EndOption = Annotated[
    float | None, typer.Option(help="Leave out what is after, in seconds.", show_default=False)
]
PageOption = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="The page to write; without it none.", show_default=False),
]


def allan(
    file: RecordingArgument,
    begin: BeginOption = None,
    end: EndOption = None,
    page: PageOption = None,
    as_json: JsonOption = False,
) -> None:
    """Noise of a gyroscope and an accelerometer that lie still: Allan deviation, figures of it.

    Per axis angle or velocity random walk, bias instability and random walk as far as the record
    shows them, beside the datasheet's noise. A minute tells white noise, an hour or more bias
    instability. Record every sample of a board that nobody touches:
    terazi set imu.every=1 uart.baud=500000, then terazi log --imu --seconds 7200.

    [dim]Examples:[/]  terazi attitude allan night.terazi
    terazi attitude allan night.npz --begin 60 -o night.html
    """
    from terazi.applications.attitude import load_record
    from terazi.applications.attitude.allan import allan as deviations

    wanted_page(page, file)
    record = load_record(file).between(begin, end)
    with errors.status("working ..."):
        found = deviations(record)
        if page:
            with_plotly()
            from terazi.applications.attitude.allan_page import write_allan

            write_allan(page, found)
    if as_json:
        print(json.dumps(found.plain()))
        return
    _show(found)
    if page:
        out.print(f"page  {page}", soft_wrap=True)


def wanted_page(page: Path | None, source: Path) -> None:
    """Raises UsageError where the page would overwrite what it is made of."""
    from terazi.errors import UsageError

    if page and page.resolve() == source.resolve():
        raise UsageError(f"{page} would overwrite what the page is made of")


def with_plotly() -> None:
    """Raises UsageError where plots cannot be made."""
    from importlib.util import find_spec

    from terazi.errors import UsageError

    if find_spec("plotly") is None:
        raise UsageError("plots need plotly", remedy="Install it: pip install 'terazi[report]'")


def _show(found) -> None:
    from terazi.applications.attitude.allan_table import HEADINGS, acc_rows, gyro_rows

    out.print(f"{found.name}: {found.duration_s:.0f} s at {found.rate_hz:g} samples a second")
    for sensor, rows in (("gyro", gyro_rows(found)), ("acc", acc_rows(found))):
        table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
        for at, heading in enumerate(HEADINGS[sensor]):
            table.add_column(heading, justify="right" if at else "left", no_wrap=True)
        for row in rows:
            table.add_row(*row)
        out.print()
        out.print(table)
    for note in found.notes:
        out.print(f"note: {note}", style="yellow", markup=False)
    out.print(
        "Densities are one-sided. <: the curve still falls, a longer record would show less. –: "
        "the curve shows none.",
        style="dim",
    )
