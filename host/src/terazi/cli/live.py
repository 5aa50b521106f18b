# SPDX-License-Identifier: MIT
"""`terazi live`."""

from pathlib import Path
from typing import Annotated

import typer

from terazi.cli.board import board
from terazi.cli.common import BAUD_DEFAULT, BaudOption, PortArgument, out


def live(
    port: PortArgument = None,
    record_to: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="The capture that key r writes; without it, one named by the time.",
            show_default=False,
        ),
    ] = None,
    baud: BaudOption = BAUD_DEFAULT,
) -> None:
    """Weight and attitude in the terminal, live. Resets the board.

    Keys: t tares, z sets zero, c clears the tare, x switches the board to text lines and back,
    r begins and ends a recording, f lists the faults with what to do, q quits. 80 x 24 will do,
    also over ssh. Where there is no terminal, use `terazi watch`.

    [dim]Examples:[/]  terazi live      terazi live /dev/ttyACM0 -o walk.terazi
    """
    from terazi.errors import UsageError

    try:
        from terazi.live.app import LiveApp
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "textual":
            raise
        raise UsageError(
            "terazi live draws with textual, which is not installed",
            remedy="pip install 'terazi[live]', or use `terazi watch`",
        ) from None
    if not out.is_terminal:
        raise UsageError("terazi live needs a terminal", remedy="In a pipe use `terazi watch`.")

    from terazi.live.session import Session

    where = None if record_to is None else lambda: record_to
    with board(port, baud) as link, Session(link, record_to=where) as session:
        LiveApp(session).run()
    for words in session.recorded:
        out.print(f"recorded  {words}", markup=False, soft_wrap=True)
    if session.fault is not None:
        raise session.fault
