# SPDX-License-Identifier: MIT
"""`terazi tare`."""

import json
from typing import Annotated

import typer

from terazi.cli.board import WaitOption, board
from terazi.cli.common import BAUD_DEFAULT, BaudOption, JsonOption, PortArgument, errors, out


def tare(
    port: PortArgument = None,
    clear: Annotated[bool, typer.Option("--clear", help="No tare: weigh gross again.")] = False,
    zero: Annotated[
        bool, typer.Option("--zero", help="Take what lies there as zero, within 2 % of Max.")
    ] = False,
    wait: WaitOption = 5.0,
    baud: BaudOption = BAUD_DEFAULT,
    as_json: JsonOption = False,
) -> None:
    """Take the container's weight off, once it stands still. Resets the board.

    The tare is kept in EEPROM. --zero is for an empty scale that does not show zero.

    [dim]Examples:[/]  terazi tare      terazi tare --clear      terazi tare --zero --wait 10
    """
    from terazi.control import Balance
    from terazi.control.quantities import show_mass
    from terazi.errors import UsageError

    if clear and zero:
        raise UsageError("--clear and --zero are two commands: give one")
    with board(port, baud) as link:
        balance = Balance(link)
        balance.quiet_stream()
        with errors.status("waiting for the load to stand still ...") as status:

            def show(now: Balance) -> None:
                if now.weight is not None:
                    status.update(
                        f"{show_mass(now.weight.net_mg)}, moves by {show_mass(now.spread_mg)}"
                    )

            if clear:
                weight = balance.clear()
            else:
                weight = (balance.zero if zero else balance.tare)(wait, show)
            balance.wait_saved()
    if as_json:
        words = {"net_mg": weight.net_mg, "zero_mg": weight.zero_mg, "tare_mg": weight.tare_mg}
        print(json.dumps(words))
        return
    done = "no tare" if clear else "zero is set" if zero else f"tare {show_mass(weight.tare_mg)}"
    out.print(f"{done}; net {show_mass(weight.net_mg)}; saved")
