# SPDX-License-Identifier: MIT
"""`terazi report`."""

from pathlib import Path
from typing import Annotated

import typer

from terazi.cli.common import errors, out
from terazi.cli.replay import CaptureArgument


def report(
    capture: CaptureArgument,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="The page to write; without it, beside the capture.",
            show_default=False,
        ),
    ] = None,
    truth: Annotated[
        Path | None,
        typer.Option(
            help="CSV of what really lay on the scale, with columns t_s and load_g.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Show a recording as one HTML page: plots, settling times, noise, spectrum, timing, health.

    The page opens from disk in any browser and needs no network. An older page of that name is
    replaced.

    [dim]Examples:[/]  terazi report weights.terazi
    terazi report weights.terazi --truth weights.csv -o weights.html
    """
    from terazi.errors import UsageError
    from terazi.recorder import load_recording

    page = output or capture.with_suffix(".html")
    if page.resolve() in {path.resolve() for path in (capture, truth) if path}:
        raise UsageError(f"{page} would overwrite what the report is made of")
    recording = load_recording(capture)
    with errors.status("working ..."):
        from terazi.report import analyse, load_truth, write_report

        known = load_truth(truth) if truth else None
        write_report(page, recording, analyse(recording, known))
    out.print(f"report  {page}", soft_wrap=True)
