# SPDX-License-Identifier: MIT
"""`terazi replay`."""

import dataclasses
import json
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from terazi.cli.common import JsonOption, errors, out

CaptureArgument = Annotated[
    Path, typer.Argument(help="A capture that `terazi log` made.", show_default=False)
]


def replay(capture: CaptureArgument, as_json: JsonOption = False) -> None:
    """Compute a recording's answers again, with the firmware's C and with the float models.

    Every answer of the device must be that of its C on this machine, bit for bit, and lie within
    the error budget around the models. Exit code 10 if not, with the first differences. Attitudes
    are verified where `terazi log --imu` recorded every sample (imu.every=1).

    [dim]Examples:[/]  terazi replay weights.terazi      terazi replay weights.terazi --json
    """
    from terazi.errors import ReplayDisagrees
    from terazi.recorder import load_recording
    from terazi.replay import replay as run

    recording = load_recording(capture, needs_samples=False)
    result = run(recording)
    if as_json:
        print(json.dumps(_plain(recording, result)))
    else:
        _show(recording, result)
    if not result.agrees:
        what = "the float models" if result.is_bit_identical else "this host's C"
        raise ReplayDisagrees(f"{capture}: the device's answers are not those of {what}")


def _plain(recording, result) -> dict:
    return {
        "capture": str(recording.path),
        "agrees": result.agrees,
        "bit_identical": result.is_bit_identical,
        "samples": result.samples,
        "frames_lost": recording.frames_lost,
        "segments": len(result.segments),
        "segments_begun_in_mid_stream": result.unprimed,
        "fir_design": result.design,
        "kf_schedule": result.schedule,
        "chains": result.chains,
        "unverified": [dataclasses.asdict(one) for one in result.unverified],
        "stages": [dataclasses.asdict(stage) for stage in result.stages],
        "models": [
            {
                "stage": model.stage,
                "unit": model.unit,
                "compared": model.compared,
                "beyond_budget": model.beyond,
                "largest": model.largest,
                "budget": model.budget,
            }
            for model in result.models
        ],
    }


def _show(recording, result) -> None:
    if result.samples:
        out.print(
            f"{result.samples} samples in {len(result.segments)} "
            f"{'segment' if len(result.segments) == 1 else 'segments'}, "
            f"FIR {result.design}, Kalman {result.schedule}; "
            f"order and Kalman filter: {'; then '.join(result.chains)}"
        )
    else:
        out.print("no samples of the scale")
    head = ("stage", "against", "compared", "verdict", "largest", "budget")
    table = Table(*head, box=None, pad_edge=False)
    for stage in result.stages:
        verdict = _verdict(stage.compared, stage.differing, "bit-identical", "differ")
        table.add_row(stage.stage, "the C", str(stage.compared), verdict)
    for model in result.models:
        table.add_row(
            model.stage,
            "float model",
            str(model.compared),
            _verdict(model.compared, model.beyond, "within", "beyond"),
            f"{model.largest:.3g} {model.unit}" if model.compared else "",
            f"{model.budget:.3g} {model.unit}" if model.compared else "",
        )
    out.print(table)
    for stage in result.stages:
        _show_differences(stage)
    if result.unprimed:
        errors.print(
            f"{result.unprimed} segments begin in mid-stream: frames were lost, or recording began "
            "late. The float models say nothing of them.",
            style="yellow",
        )
    for one in result.unverified:
        errors.print(f"not verified: {one}", style="dim", highlight=False, soft_wrap=True)
    if not recording.ended_cleanly:
        errors.print(
            f"The capture was cut off; its last {recording.cut_off_bytes} bytes are no record.",
            style="yellow",
        )


def _verdict(compared: int, wrong: int, good: str, bad: str) -> str:
    if not compared:
        return "nothing to compare"
    return f"[bold red]{wrong} {bad}[/]" if wrong else f"[green]{good}[/]"


def _show_differences(stage) -> None:
    if not stage.differing:
        return
    table = Table("sample", "number", "device", "this host", title=f"{stage.stage}: the first")
    for one in stage.first:
        table.add_row(str(one.sample), str(one.conversion), str(one.device), str(one.host))
    out.print(table)
