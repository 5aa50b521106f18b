# SPDX-License-Identifier: MIT
"""`terazi weigh score`."""

import json
from typing import Annotated

import typer
from rich.table import Table

from terazi.cli.common import JsonOption, errors, out


def score(
    seed: Annotated[int, typer.Option(help="Of all noise.", min=0)] = 2016,
    as_json: JsonOption = False,
) -> None:
    """Compare the chip's weighing filters with those of common libraries.

    Fixed point as shipped, on seeded records after the weighing thesis's Table 5: loads that change
    in steps under white noise and the hum of a belt; single steps; a load at rest.

    [dim]Examples:[/]  terazi weigh score
    terazi weigh score --json
    """
    from terazi.applications import weighing

    with errors.status("working ...") as status:
        result = weighing.score(
            weighing.Experiment(seed=seed), progress=lambda what: status.update(f"{what} ...")
        )
    if as_json:
        print(json.dumps(result.plain()))
    else:
        _show(result)


def _show(result) -> None:
    table = Table("filter", title="Weighing filters, fixed point as on the chip")
    for heading in ("relative error", "settling after a step", "noise at rest"):
        table.add_column(heading, justify="right")
    for name, noise_counts in result.noise_at_rest_counts.items():
        error_pct = result.relative_error_pct.get(name)
        table.add_row(
            name,
            "-" if error_pct is None else f"{error_pct:.3f} %",
            f"{result.settling_s[name]:.3f} s",
            f"{noise_counts:.2f} counts",
        )
    out.print(table)
    for sentence in result.words:
        out.print(f"- {sentence}")
