# SPDX-License-Identifier: MIT
"""`terazi flash`."""

from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from terazi.cli.common import PortArgument, errors, out, show_version

BOOT_BAUD = 115_200  # optiboot's on an Uno, whatever uart.baud says

HexOption = Annotated[
    Path | None,
    typer.Option(
        "--hex",
        help="Image to write, an Intel HEX file. May be left out in a clone of the sources, where "
        "./dev builds one.",
        show_default=False,
    ),
]
BootBaudOption = Annotated[
    int, typer.Option("--baud", help="Of the boot loader; old Nanos: 57600.", min=1)
]


def flash(
    port: PortArgument = None, hex_path: HexOption = None, baud: BootBaudOption = BOOT_BAUD
) -> None:
    """Program an Arduino Uno with Terazi's firmware and see it answer.

    Needs avrdude. Verifies what it wrote, and names the version before and after.

    [dim]Examples:[/]  terazi flash      terazi flash /dev/ttyACM0 --hex terazi.hex
    """
    from terazi.link.flasher import flash as flash_board

    with _progress() as progress:
        bar = _Bar(progress)
        done = flash_board(port, hex_path, baud=baud, on_stage=bar.show)
    out.print(f"before  {_who(done.before)}", soft_wrap=True)
    out.print(f"after   {_who(done.after)}", soft_wrap=True)
    out.print(
        f"wrote and verified {done.image.used_bytes} bytes of {done.image.path} at {done.port}",
        soft_wrap=True,
    )


def _progress() -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        console=errors,
        transient=True,
        disable=not errors.is_terminal,
    )


class _Bar:
    """One line of progress a stage; where there is no terminal, one line at its beginning."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._stage = ""
        self._task = None

    def show(self, stage: str, done: float | None) -> None:
        if stage != self._stage:
            self._begin(stage, done)
        if done is not None:
            self._progress.update(self._task, completed=done)

    def _begin(self, stage: str, done: float | None) -> None:
        self._stage = stage
        if self._task is not None:
            self._progress.remove_task(self._task)
        self._task = self._progress.add_task(stage, total=None if done is None else 1.0)
        if not errors.is_terminal:
            errors.print(f"{stage} ...")


def _who(answer) -> str:
    from terazi.errors import FingerprintMismatch

    if answer is None:
        return "no Terazi firmware answered"
    if isinstance(answer, FingerprintMismatch):
        return f"Terazi of another version: {answer}"
    return f"Terazi {show_version(answer)}"
