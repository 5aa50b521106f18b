# SPDX-License-Identifier: MIT
"""`terazi design`: FIR filters for a rate as it was measured, and what an adaptive one could do."""

import dataclasses
import json
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from terazi.cli.common import JsonOption, errors, out

MAINS_HZ = (50.0, 60.0)

design = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode="rich",
    help="Design FIR filters: terazi design fir hamming equiripple --rate 91.7 --notch 50",
)


@design.command("fir")
def fir(
    methods: Annotated[
        list[str],
        typer.Argument(
            help="One or more of frequency-sampling, rectangular, hamming, hann, blackman, "
            "equiripple, or a design that the firmware has, as lowpass32.",
            show_default=False,
        ),
    ],
    rate: Annotated[
        float, typer.Option(help="Samples a second as measured: terazi info tells them.")
    ] = 80.0,
    taps: Annotated[int, typer.Option(help="Number of coefficients, 2 to 64.")] = 32,
    pass_to: Annotated[
        float, typer.Option(help="End of the pass band in Hz; 0: a weight that stands still.")
    ] = 0.0,
    stop_from: Annotated[
        float | None,
        typer.Option(help="Beginning of the stop band in Hz.", show_default=False),
    ] = None,
    stop_db: Annotated[
        float | None,
        typer.Option(
            help="What the stop band may have at most, as -50. Exit code 12 if a design has more.",
            show_default=False,
        ),
    ] = None,
    notch: Annotated[
        list[float] | None,
        typer.Option(
            help="A frequency to be nulled, as it is in the world: 50 or 60 for mains, the belt's. "
            "Where it folds to is worked out. May be given several times.",
            show_default=False,
        ),
    ] = None,
    at: Annotated[
        list[float] | None,
        typer.Option(
            help="Show the gain at this frequency too, as it is in the world; without it, at the "
            "mains'. May be given several times.",
            show_default=False,
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="Write the responses: FILE.html or FILE.svg.", show_default=False
        ),
    ] = None,
    export: Annotated[
        Path | None,
        typer.Option(
            help="Write one design's coefficients as JSON, to be loaded as settings.",
            show_default=False,
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Design low-passes, quantise them as the chip has them, and say what is left.

    All figures are those of the quantised coefficients, whose sum is exactly 1.

    [dim]Examples:[/]  terazi design fir hamming blackman equiripple --taps 51 --rate 91.7
    terazi design fir hamming --notch 50 --notch 13.7 --export taps.json -o response.html
    """
    from terazi.design import lowpass
    from terazi.errors import DesignMisses, UsageError

    if export and len(methods) != 1:
        raise UsageError("--export takes the coefficients of one design")
    if output and output.suffix not in (".html", ".svg"):
        raise UsageError(f"{output}: the responses are written as .html or .svg")
    common = {
        "rate_hz": rate,
        "taps": taps,
        "pass_to_hz": pass_to,
        "stop_from_hz": stop_from,
        "stop_max_db": stop_db,
        "notches_hz": tuple(notch or ()),
    }
    try:
        filters = [lowpass.design(lowpass.Wish(method, **common)) for method in methods]
    except ValueError as error:
        raise UsageError(str(error)) from None
    except ModuleNotFoundError as error:
        raise UsageError(
            f"this design needs {error.name}", remedy="Install it: pip install 'terazi[design]'"
        ) from None
    shown_hz = tuple(at) if at else MAINS_HZ
    if export:
        _write(export, json.dumps(_plain(filters[0], shown_hz), indent=2) + "\n")
    if output:
        _write(output, _picture(filters, output.suffix))
    if as_json:
        print(json.dumps([_plain(each, shown_hz) for each in filters]))
    else:
        _show(filters, shown_hz)
    misses = [f"{each.name}: {miss}" for each in filters for miss in each.figures.misses]
    if misses:
        raise DesignMisses("; ".join(misses), remedy="More taps, or a stop band further up.")


def _plain(filter_, shown_hz) -> dict:
    """A design as JSON: the wish, the coefficients for fir_load, the figures."""
    from terazi.design.lowpass import level_db

    taps_q15 = filter_.taps_q15.tolist()
    rate_hz = filter_.wish.rate_hz
    levels = level_db(filter_.taps_q15, shown_hz, rate_hz)
    return {
        "wish": dataclasses.asdict(filter_.wish),
        "taps": len(taps_q15),
        "half_q15": taps_q15[: (len(taps_q15) + 1) // 2],
        "taps_q15": taps_q15,
        "figures": dataclasses.asdict(filter_.figures),
        "gain_db": dict(zip(map(str, shown_hz), map(float, levels), strict=True)),
    }


def _show(filters, shown_hz) -> None:
    from terazi.design.lowpass import level_db
    from terazi.design.notch import folded_hz

    wish = filters[0].wish
    table = Table("at " + f"{wish.rate_hz:g} samples a second", box=None, pad_edge=False)
    for each in filters:
        table.add_column(each.wish.method, justify="right")

    def row(name: str, values) -> None:
        table.add_row(name, *values)

    figures = [each.figures for each in filters]
    row("taps", (str(len(each.taps_q15)) for each in filters))
    row("noise, out over in", (f"{each.noise_gain:.3f}" for each in figures))
    row("group delay", (f"{each.delay_s * 1e3:.1f} ms" for each in figures))
    row("a step settled to 1e-4", (f"{each.settling_s * 1e3:.0f} ms" for each in figures))
    row("overshoot", (f"{each.overshoot:.1%}" for each in figures))
    if wish.pass_to_hz:
        row(f"at {wish.pass_to_hz:g} Hz", (f"{each.pass_min_db:.2f} dB" for each in figures))
    row("stop band from", (f"{each.wish.stop_from_hz:.2f} Hz" for each in filters))
    row("stop band", (f"{each.stop_max_db:.1f} dB" for each in figures))
    for hz in dict.fromkeys((*wish.notches_hz, *shown_hz)):
        folded = float(folded_hz(hz, wish.rate_hz))
        name = f"{hz:g} Hz" if abs(folded - hz) < 1e-6 else f"{hz:g} Hz, folded to {folded:.2f} Hz"
        levels = (level_db(each.taps_q15, [hz], wish.rate_hz)[0] for each in filters)
        row(name, (f"{level:.1f} dB" for level in levels))
    out.print(table)
    if len(filters) == 1:
        half = _plain(filters[0], shown_hz)["half_q15"]
        out.print(f"half_q15 of {len(filters[0].taps_q15)}: {', '.join(map(str, half))}")


def _picture(filters, suffix: str) -> str:
    from terazi.design import plot
    from terazi.design.notch import folded_hz
    from terazi.errors import UsageError

    curves = []
    for each in filters:
        wish = each.wish
        marks = tuple((float(folded_hz(hz, wish.rate_hz)), f"{hz:g} Hz") for hz in wish.notches_hz)
        curves.append(
            plot.Curve(
                each.name, each.taps_q15, wish.rate_hz, wish.stop_from_hz, wish.stop_max_db, marks
            )
        )
    if suffix == ".svg":
        return plot.svg(curves)
    try:
        return plot.page(curves, f"FIR designs at {filters[0].wish.rate_hz:g} samples a second")
    except ModuleNotFoundError as error:
        raise UsageError(
            f"an HTML page needs {error.name}",
            remedy="Write an .svg, or install it: pip install 'terazi[report]'",
        ) from None


def _write(path: Path, text: str) -> None:
    from terazi.recorder.files import cannot_write

    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise cannot_write(path, error) from error
    errors.print(f"wrote {path}", soft_wrap=True, markup=False)


@design.command("lms")
def lms(
    seed: Annotated[int, typer.Option(help="Of the eggs, the belt and the noise.")] = 2017,
    dwell: Annotated[float, typer.Option(help="Seconds that an egg is on the scale.")] = 1.0,
    as_json: JsonOption = False,
) -> None:
    """Weigh eggs on a moving belt: an adaptive LMS line enhancer beside windows.

    A simulated experiment after Yanik 2017, at three rhythms of the belt. Float64 only: it shows
    what an adaptive filter could do, the chip has none. Beside windows of its own mean's length,
    and one of twice that: this is what the enhancer remembers, and waits for.

    [dim]Example:[/]  terazi design lms --seed 3
    """
    from terazi.design import comparison
    from terazi.errors import UsageError

    if not 0.1 <= dwell <= 60:
        raise UsageError(f"an egg stays for 0.1 to 60 s, not for {dwell:g} s")
    experiments = [
        comparison.Experiment(seed=seed, dwell_s=dwell, belt_hz=hz) for hz in comparison.BELTS_HZ
    ]
    results = [comparison.run(each) for each in experiments]
    if as_json:
        pairs = zip(experiments, results, strict=True)
        print(json.dumps([comparison.as_json(*pair) for pair in pairs]))
        return
    table = Table("filter", box=None, pad_edge=False)
    for hz in comparison.BELTS_HZ:
        table.add_column(f"belt {hz:g} Hz", justify="right")
    for rows in zip(*results, strict=True):
        table.add_row(rows[0].filter, *(f"{row.relative_error_pct:.3f} %" for row in rows))
    out.print(table)
    one = experiments[0]
    out.print(
        f"[dim]mean relative error over {one.eggs} eggs, {one.dwell_s:g} s each at "
        f"{one.rate_hz:g} samples a second, rhythm {one.belt_g:g} g + {one.harmonic_g:g} g, noise "
        f"{one.noise_g:g} g, filters of {one.taps} taps, seed {one.seed}; the first sixth is for "
        "learning[/]"
    )
