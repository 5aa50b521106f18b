# SPDX-License-Identifier: MIT
"""`terazi report`."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

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
        figures = analyse(recording, known)
        write_report(page, recording, figures)
    _show(figures)
    out.print(f"report  {page}", soft_wrap=True)


def _show(figures) -> None:
    """The page's figures of each stage: the slowest settling, noise and error."""
    table = Table("stage", box=None, pad_edge=False)
    for heading in ("settles within", "noise rms", "peak to peak", "error rms"):
        table.add_column(heading, justify="right")
    for stage, noise_g in figures.noise_rms_g.items():
        times_s = [step.settling_s.get(stage) for step in figures.steps]
        error_g = figures.truth_error_g.get(stage)
        table.add_row(
            stage,
            "" if not times_s else "never" if None in times_s else f"{max(times_s):.2f} s",
            f"{noise_g:.3f} g",
            f"{figures.noise_p2p_g[stage]:.3f} g",
            "" if error_g is None else f"{error_g:.3f} g",
        )
    out.print(table)
