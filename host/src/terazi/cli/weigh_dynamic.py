# SPDX-License-Identifier: MIT
"""`terazi weigh dynamic`."""

import json
import tempfile
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Column, Table

from terazi.cli.common import JsonOption, errors, out

LEAD_S = 15.0  # empty belt, in which the device finds its zero and is set up
SPEED = 4.0  # simulated seconds a second
TAIL_S = 0.5  # after the last product


def dynamic(
    products: Annotated[int, typer.Option(help="How many pass.", min=8)] = 240,
    seed: Annotated[int, typer.Option(help="Of the belt and of all noise.", min=0)] = 2027,
    port: Annotated[
        str | None,
        typer.Option(
            help="Board whose cell feels the belt: a simulated one, started with the file of "
            "--scenario.",
            show_default=False,
        ),
    ] = None,
    scenario: Annotated[
        Path | None,
        typer.Option(
            help="Write the belt there (.npz) for a simulated Uno, and weigh nothing unless "
            "--port is given too.",
            show_default=False,
        ),
    ] = None,
    page: Annotated[
        Path | None,
        typer.Option(help="Write plots there, one HTML page.", show_default=False),
    ] = None,
    on_host: Annotated[
        bool, typer.Option("--host", help="Weigh by the same C on this machine, without a device.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Weigh products that pass over a simulated checkweigher's belt, 120 a minute.

    The simulated Uno weighs them with the firmware that was built, where both are found; else the
    same C on this machine does. Beside it stand common filters on the same samples, each at its
    best setting found on other products.

    [dim]Examples:[/]  terazi weigh dynamic
    terazi weigh dynamic --host --products 1000 --json
    terazi weigh dynamic --page belt.html
    """
    from terazi.applications.weighing import dynamic as weighing
    from terazi.applications.weighing.belt import Belt, simulate
    from terazi.cli.virtual_uno import find_image, virtual_uno

    record = simulate(Belt(seed=seed, products=products, lead_s=LEAD_S))
    if scenario is not None:
        _save(record, scenario)
        if port is None:
            out.print(f"scenario  {scenario}", soft_wrap=True)
            return
    image = None if on_host or port is not None else find_image()
    with errors.status("working ...") as status:

        def progress(what: str) -> None:
            status.update(f"{what} ...")

        if port is not None:
            verdicts, samples = _on_device(port, record, progress)
        elif image is not None:
            with tempfile.TemporaryDirectory(prefix="terazi-") as folder:
                belt = Path(folder) / "belt.npz"
                _save(record, belt)
                options = ("--scenario", belt, "--rate", weighing.RATE_HZ, "--speed", SPEED)
                noise = ("--noise", weighing.NOISE_COUNTS, "--seed", seed)
                with virtual_uno(image, *options, *noise) as own_port:
                    verdicts, samples = _on_device(own_port, record, progress)
        else:
            verdicts, samples = weighing.weigh_on_host(record, seed=seed)
        weighed_by = "host C" if port is None and image is None else "device"
        result = weighing.score(record, verdicts, samples, weighed_by=weighed_by, progress=progress)
    if page is not None:
        from terazi.report.belt import write_belt_page

        write_belt_page(page, record, samples, result)
    if as_json:
        print(json.dumps(result.plain()))
        return
    _show(result)
    if page is not None:
        out.print(f"page  {page}", soft_wrap=True)


def _save(record, path: Path) -> None:
    np.savez(
        path, load_g=record.load_g, truth_g=record.truth_g, rate_hz=np.array(record.belt.rate_hz)
    )


def _on_device(port: str, record, progress):
    """What the board at the port says, with its own samples. Opening the port starts the belt."""
    from terazi.applications.weighing.dynamic import CONFIG, from_device
    from terazi.control.products import collect, switch_on
    from terazi.errors import TeraziError
    from terazi.link import open_link

    with open_link(port) as link:
        progress(f"waiting for {port}")
        link.hello()
        progress("setting up the checkweigher")
        switch_on(link, CONFIG)
        last_s = record.passages[-1].leaves_s + TAIL_S
        count = len(record.passages)
        passed = collect(
            link, round(last_s * 1e6), lambda done: progress(f"{done} of {count} products passed")
        )
    if not passed.samples or passed.samples[0][0] * 1e-6 > record.passages[0].enters_s:
        raise TeraziError("the first product had passed before the device was set up")
    return from_device(passed.products, passed.samples)


def _show(result) -> None:
    table = Table(Column("", no_wrap=True), title="Products on a simulated belt, in e = 1 g")
    for heading in ("mean error", "sigma", *result.per_tone):
        table.add_column(heading, justify="right")
    rows = {"checkweigher": (result, result.per_tone)}
    for name, part in result.peers.items():
        rows[name] = (part, {tone: each[name] for tone, each in result.peers_per_tone.items()})
    for name, (whole, parts) in rows.items():
        sigmas = (f"{part.sigma_e:.3f}" for part in parts.values())
        table.add_row(name, f"{whole.mean_error_e:+.3f}", f"{whole.sigma_e:.3f}", *sigmas)
    out.print(table)
    loads = Table("load", box=None, pad_edge=False)
    for heading in ("products", "mean error", "sigma"):
        loads.add_column(heading, justify="right")
    for name, part in result.per_load.items():
        loads.add_row(
            name, str(part.products), f"{part.mean_error_e:+.3f} e", f"{part.sigma_e:.3f} e"
        )
    out.print(loads)
    out.print(
        f"{result.throughput_per_min:.1f} products a minute, weighed by the {result.weighed_by}; "
        f"{100 * result.right_class_share:.1f} % in their class; the best common filter spreads "
        f"{result.least_ratio():.1f} times as much where that is least"
    )
