# SPDX-License-Identifier: MIT
"""`terazi ports`."""

import dataclasses
import json

from rich.table import Table

from terazi.cli.common import JsonOption, out


def ports(as_json: JsonOption = False) -> None:
    """List this computer's serial ports, boards first.

    [dim]Example:[/]  terazi ports
    """
    from terazi.link.ports import list_ports

    found = list_ports()
    if as_json:
        print(json.dumps([dataclasses.asdict(port) for port in found]))
        return
    if not found:
        out.print("no serial ports; is the board plugged in?")
        return
    table = Table("port", "board", "description", "USB id", box=None, pad_edge=False)
    for port in found:
        style = "bold" if port.is_candidate else "dim"
        table.add_row(port.path, port.board or "-", port.description, port.usb_id, style=style)
    out.print(table)
