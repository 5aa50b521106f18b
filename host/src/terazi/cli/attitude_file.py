# SPDX-License-Identifier: MIT
"""`terazi attitude FILE`."""

import json
from typing import Annotated

import typer
from rich.table import Table

from terazi.cli.attitude_allan import PageOption, RecordingArgument, wanted_page, with_plotly
from terazi.cli.common import JsonOption, errors, out


def file(
    file: RecordingArgument,
    page: PageOption = None,
    mode: Annotated[
        int | None,
        typer.Option(
            help="Of raw samples: 6 for gyroscope and accelerometer, 9 for the magnetometer too.",
            show_default="6",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """A recording's angles, rates, bias, rest and field over time, and its errors where they are
    known.

    Of a capture the device's own attitudes; of raw samples alone, or an .npz with gyr and acc in
    counts, those that the shipped fixed-point filter makes of them. With -o one HTML page that
    opens from disk. Short for it: terazi attitude FILE.

    [dim]Examples:[/]  terazi attitude turning.terazi -o turning.html
    terazi attitude broad/01_undisturbed_slow_rotation_A.npz --mode 9 --json
    """
    from terazi.errors import CannotRead

    if not file.exists():
        from terazi.cli.attitude import VERBS

        verbs = ", ".join(verb for verb in VERBS if verb != "file")
        raise CannotRead(f"there is no file {file}", remedy=f"Verbs of terazi attitude: {verbs}")
    wanted_page(page, file)
    with errors.status("working ..."):
        from terazi.applications.attitude.summary import plain, rows
        from terazi.applications.attitude.view import load_view

        view = load_view(file, mode=mode)
        if page:
            with_plotly()
            from terazi.applications.attitude.page import write_view

            write_view(page, view)
    if as_json:
        print(json.dumps(plain(view)))
        return
    table = Table(box=None, pad_edge=False, show_header=False, padding=(0, 2, 0, 0))
    for row in rows(view):
        table.add_row(*row)
    out.print(table)
    for note in view.notes:
        out.print(f"note: {note}", style="yellow", markup=False)
    if page:
        out.print(f"page  {page}", soft_wrap=True)
