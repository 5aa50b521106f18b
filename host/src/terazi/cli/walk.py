# SPDX-License-Identifier: MIT
"""`terazi walk`."""

import json
import time
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from typer.core import TyperGroup

from terazi.cli.common import JsonOption, errors, out


class FileOrVerb(TyperGroup):
    """`terazi walk FILE` means `terazi walk show FILE`."""

    def parse_args(self, ctx, args):
        if args and args[0] not in self.commands and args[0] != "--help":
            args = ["show", *args]
        return super().parse_args(ctx, args)


walk = typer.Typer(
    cls=FileOrVerb,
    no_args_is_help=True,
    rich_markup_mode="rich",
    help="The path of a foot that bears a sensor: terazi walk FILE, terazi walk score DIR",
)


class Detector(StrEnum):
    """How it is known that the foot stands."""

    adaptive_shoe = "adaptive_shoe"
    shoe = "shoe"
    rate_energy = "rate_energy"
    moving_variance = "moving_variance"
    magnitude = "magnitude"
    low_pass = "low_pass"
    learnt = "learnt"
    device = "device"


class Navigator(StrEnum):
    """What makes a path of it."""

    kalman = "kalman"
    complementary = "complementary"


DetectorOption = Annotated[
    Detector,
    typer.Option(
        help="How it is known that the foot stands. device: by its own detector, imu.zupt, told in "
        "a capture."
    ),
]
NavigatorOption = Annotated[Navigator, typer.Option(help="What integrates the path.")]
CausalOption = Annotated[
    bool, typer.Option("--causal", help="Use nothing of the future, as a device would.")
]
ThresholdOption = Annotated[
    float | None,
    typer.Option(
        help="Motion below which the foot stands, in the detector's unit: g for low_pass, m/s² for "
        "moving_variance and magnitude, a doubt of 0..1 for learnt, rad/s for the others "
        "(adaptive_shoe: the lowest one).",
        min=0,
        show_default=False,
    ),
]
WeightsOption = Annotated[
    Path | None,
    typer.Option(
        help="Weights of the learnt detector: gru8 (8 cells, the default) or lstm (the thesis's "
        "6 x 80), which are shipped, or a file that `terazi walk train` wrote.",
        metavar="NAME|FILE",
        show_default=False,
    ),
]
EliminateOption = Annotated[
    bool,
    typer.Option(
        "--eliminate-drift",
        help="Turn straight strides to the directions of a building, if that is where one walks.",
    ),
]
LayoutOption = Annotated[
    Path | None,
    typer.Option(help="TOML that names a CSV's columns and units.", show_default=False),
]
RateOption = Annotated[
    float | None,
    typer.Option(help="Samples a second, of a CSV without times.", min=1, show_default=False),
]


@walk.callback()
def _group() -> None:
    """show may be left out: terazi walk FILE."""


@walk.command()
def show(
    file: Annotated[
        Path,
        typer.Argument(
            help="A walk: a capture of terazi log --imu, .npz, or .csv with known columns.",
            show_default=False,
        ),
    ],
    detector: DetectorOption = Detector.adaptive_shoe,
    navigator: NavigatorOption = Navigator.kalman,
    causal: CausalOption = False,
    threshold: ThresholdOption = None,
    weights: WeightsOption = None,
    eliminate_drift: EliminateOption = False,
    layout: LayoutOption = None,
    rate: RateOption = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="An HTML page of plots to write.", show_default=False),
    ] = None,
    csv: Annotated[
        Path | None, typer.Option(help="A CSV of the path to write.", show_default=False)
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Compute the path of one walk: distance, strides, climb, closure; with -o, its plots.

    A capture of the board's own is read with its calibration; best with every sample in it:
    terazi set imu.every=1 uart.baud=500000, then terazi log --imu -o foot.terazi

    [dim]Examples:[/]  terazi walk foot.terazi -o walk.html
    terazi walk foot.terazi --detector device
    terazi walk mine.csv --layout mine.toml --json
    """
    from terazi.applications import walks
    from terazi.applications.walks import files

    with errors.status("reading ..."):
        record = walks.load_walk(file, layout=layout, rate_hz=rate)
    options = _options(detector, navigator, causal, threshold, weights, eliminate_drift)
    begin_s = time.perf_counter()
    with _progress() as bar:
        task = bar.add_task(record.name, total=1.0)
        result = walks.estimate(
            record, options, progress=lambda share: bar.update(task, completed=share)
        )
    summary = walks.summarise(result, computed_s=time.perf_counter() - begin_s)
    if csv:
        files.write_path(csv, result)
    if output:
        from terazi.applications.walks import page

        page.write_page(output, result)
    if as_json:
        print(json.dumps(summary.plain()))
        return
    _tell(summary)
    for note in result.walk.notes:
        errors.print(f"note: {note}", style="yellow", markup=False)
    for written in (output, csv):
        if written:
            out.print(f"written {written}", soft_wrap=True)


@walk.command()
def score(
    folder: Annotated[
        Path,
        typer.Argument(
            help="Folder of walks, .npz, .csv and captures, or one.", show_default=False
        ),
    ],
    only: Annotated[str, typer.Option(help="Walks whose names begin so.", show_default=False)] = "",
    detector: DetectorOption = Detector.adaptive_shoe,
    navigator: NavigatorOption = Navigator.kalman,
    causal: CausalOption = False,
    threshold: ThresholdOption = None,
    weights: WeightsOption = None,
    eliminate_drift: EliminateOption = False,
    layout: LayoutOption = None,
    rate: RateOption = None,
    as_json: JsonOption = False,
) -> None:
    """Tell how far the paths of a folder are from the truth; one setting for all.

    Root mean squares of the Euclidean distance. Heading is free: each path is turned about the
    vertical as fits best, about its mean (optical truth) or its start (footprints). Closure is the
    distance from the first to the last position, where the foot returned or nothing is known.

    [dim]Examples:[/]  terazi walk score vicon/
    terazi walk score footprints/ --causal --json
    """
    from terazi.applications import walks

    paths = walks.find_walks(folder, only)
    options = _options(detector, navigator, causal, threshold, weights, eliminate_drift)
    with errors.status("reading ..."):
        records = [walks.load_walk(path, layout=layout, rate_hz=rate) for path in paths]
    with _progress() as bar:
        task = bar.add_task("walks", total=len(records))

        def positions(record):
            bar.update(task, description=record.name)
            found = walks.estimate(record, options).path.pos_w_m
            bar.advance(task)
            return found

        result = walks.score(records, positions)
    if as_json:
        print(json.dumps(result.plain()))
    else:
        _show(result, options)


class Route(StrEnum):
    """Where the simulated foot goes."""

    square = "square"
    circle = "circle"
    corridor = "corridor"
    stairs = "stairs"
    run = "run"
    ten_minutes = "ten_minutes"


@walk.command()
def simulate(
    route: Annotated[Route, typer.Argument(help="Where the foot goes.", show_default=False)],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="The .npz to write.", show_default=False)
    ],
    seed: Annotated[int, typer.Option(help="Of the sensor's errors.", min=0)] = 1,
    rate: Annotated[float, typer.Option(help="Samples a second.", min=50, max=1000)] = 200.0,
) -> None:
    """Write a simulated walk with its exact path, as an .npz that the other verbs read.

    [dim]Examples:[/]  terazi walk simulate square -o square.npz
    terazi walk square.npz
    python -m virtual_uno --imu mpu6050 --motion square.npz ... feels it, at a rate of 1000
    """
    from terazi.applications.walks import formats, simulator

    pieces = simulator.ROUTES[route.value]()
    made = simulator.simulate(pieces, seed=seed, rate_hz=rate, name=output.stem)
    formats.save_walk(output, made)
    out.print(f"written {output}, {made.t_s[-1]:.0f} s", soft_wrap=True)


class Net(StrEnum):
    """What is trained."""

    gru8 = "gru8"
    lstm = "lstm"


@walk.command()
def train(
    folder: Annotated[
        Path,
        typer.Argument(help="Folder of walks with labels or a known path.", show_default=False),
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="The .npz to write.", show_default=False)
    ],
    net: Annotated[
        Net, typer.Option(help="gru8: 297 numbers. lstm: the thesis's 287 522.")
    ] = Net.gru8,
    epochs: Annotated[int | None, typer.Option(help="Rounds.", min=1, show_default=False)] = None,
    seed: Annotated[int, typer.Option(help="Of weights, order and noise.", min=0)] = 1,
) -> None:
    """Train a detector of zero velocity. Needs PyTorch, the extra \\[train]; nothing else does.

    Labels are the records' own, or chosen by the path; each window is turned at random, scaled
    and made noisy. The same seed gives the same weights on the same machine. On one idle core gru8
    takes some three minutes, lstm some twenty.

    [dim]Examples:[/]  terazi walk train vicon/ -o gru8.npz
    terazi walk train vicon/ -o lstm.npz --net lstm
    """
    from dataclasses import replace

    from terazi.applications import walks
    from terazi.applications.walks import networks, training

    training.pytorch()  # who lacks it shall know before anything is read
    networks.check_place(output)
    asked = replace(training.KINDS[net.value], seed=seed)
    if epochs is not None:
        asked = replace(asked, epochs=epochs)
    records = [walks.load_walk(path) for path in walks.find_walks(folder)]
    with _progress(TimeRemainingColumn()) as bar:
        task = bar.add_task("training", total=1.0)
        network = training.train(
            records,
            asked,
            progress=lambda share, loss: bar.update(
                task, completed=share, description=f"training, loss {loss:.3f}"
            ),
        )
    networks.save_network(output, network)
    out.print(f"written {output}, {network.parameters} numbers", soft_wrap=True)


@walk.command()
def tables(
    folder: Annotated[
        Path | None,
        typer.Argument(
            help="Folder of x-io's records with stairsAndCorridor*.csv, for the article's own.",
            show_default=False,
        ),
    ] = None,
    weights: WeightsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Reproduce the tables of the two documents, on simulated walks whose truth is exact.

    The article's: a corridor of 26 m with stairs, X error and Y drift with and without drift
    elimination. The thesis's: squares, circles, stairs, a standard detector against learnt ones;
    --weights adds one.

    [dim]Examples:[/]  terazi walk tables
    terazi walk tables xio_2011/ --json
    """
    from terazi.applications.walks import tables as of

    with _progress() as bar:
        task = bar.add_task("", total=1.0)
        found = of.tables(
            folder,
            weights,
            progress=lambda share, words: bar.update(task, completed=share, description=words),
        )
    if as_json:
        print(json.dumps({one.name: one.plain() for one in found}))
        return
    for one in found:
        table = Table(*one.headings, title=one.title)
        for row in one.rows:
            table.add_row(*(each if isinstance(each, str) else f"{each:.3f}" for each in row))
        out.print(table)
        for note in one.notes:
            out.print(f"- {note}", soft_wrap=True)


def _options(detector, navigator, causal, threshold, weights, eliminate_drift):
    from terazi.applications import walks
    from terazi.errors import UsageError

    if weights is not None and detector is not Detector.learnt:
        raise UsageError("only a learnt detector has weights", remedy="Add: --detector learnt")
    return walks.Options(
        detector=detector.value,
        navigator=navigator.value,
        causal=causal,
        threshold=threshold,
        weights=weights,
        eliminate_drift=eliminate_drift,
    )


def _progress(*more) -> Progress:
    columns = TextColumn("{task.description}"), BarColumn(), *more
    return Progress(*columns, console=errors, transient=True)


def _tell(summary) -> None:
    table = Table(box=None, show_header=False, pad_edge=False)
    for name, value in summary.rows():
        table.add_row(name, value)
    out.print(table)


def _show(result, options) -> None:
    title = f"{options.detector}, {options.navigator}{', causal' if options.causal else ''}"
    table = Table("walk", title=title)
    for heading in ("2-D rms", "3-D rms", "closure"):
        table.add_column(heading, justify="right")
    for name, one in result.trials.items():
        table.add_row(name, *_metres(one))
    table.add_section()
    table.add_row("mean", *_metres(result.mean))
    out.print(table)


def _metres(one) -> list[str]:
    values = (one.rmse_2d_m, one.rmse_3d_m, one.closure_m)
    return ["-" if value is None else f"{value:.3f} m" for value in values]
