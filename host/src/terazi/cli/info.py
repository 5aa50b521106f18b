# SPDX-License-Identifier: MIT
"""`terazi info`."""

import json
from typing import Annotated

import typer
from rich.table import Table

from terazi.cli.common import (
    BAUD_DEFAULT,
    BaudOption,
    JsonOption,
    PortArgument,
    errors,
    out,
    show_rate,
    show_version,
)

# The device knows its converter's rate after some conversions (0.2 s at 80 SPS, 2 s at 10 SPS).
RATE_WAIT_S = 3.0


def info(
    port: PortArgument = None,
    baud: BaudOption = BAUD_DEFAULT,
    as_json: JsonOption = False,
    wait: Annotated[
        float, typer.Option(help="Seconds to wait for a measured rate.", min=0.0)
    ] = RATE_WAIT_S,
) -> None:
    """Say who is at the port: firmware, converter, filters, health. Resets the board.

    [dim]Examples:[/]  terazi info      terazi info /dev/ttyACM0 --json
    """
    from terazi.link import find_port, open_link

    port = find_port(port)
    with errors.status(f"waiting for {port} ..."), open_link(port, baud) as link:
        hello = link.hello()
        status = _status_with_rate(link, wait)
    if as_json:
        print(json.dumps(_plain(port, hello, status)))
    else:
        _show(port, hello, status)


def _status_with_rate(link, wait_s: float):
    status = link.status()
    end_s = link.now_s() + wait_s
    while not status.converter_rate_hz_q16 and link.now_s() < end_s:
        link.poll(0.2)
        status = link.status()
    return status


def _plain(port: str, hello, status) -> dict:
    from terazi.link.plain import plain_message

    return {"port": port, "hello": plain_message(hello), "status": plain_message(status)}


def _show(port: str, hello, status) -> None:
    from terazi.cshared import FIR_DESIGNS
    from terazi.link.plain import plain_message

    table = Table.grid(padding=(0, 2))
    table.add_row("port", port)
    table.add_row("firmware", show_version(hello))
    table.add_row("protocol", f"0x{hello.protocol_fingerprint:04X}")
    table.add_row("reset cause", _words(hello.reset_cause))
    table.add_row("converter", _words(status.converter_state))
    table.add_row("measured rate", show_rate(status.converter_rate_hz_q16))
    table.add_row("gain", str(hello.gain))
    table.add_row("FIR", f"{_name(FIR_DESIGNS, hello.fir_design)}, {hello.fir_taps} taps")
    table.add_row("Kalman", _kalman(hello))
    table.add_row("order", _words(hello.chain_order).replace(" ", " then ").replace("kf", "Kalman"))
    shown = {"converter_state", "converter_rate_hz"}
    for name, value in plain_message(status).items():
        if name not in shown:
            table.add_row(
                name.replace("_", " "), f"[red]{value}[/]" if _is_bad(name, value) else str(value)
            )
    out.print(table)


def _kalman(hello) -> str:
    from terazi.cshared import WEIGHT_KF_SCHEDULES
    from terazi.link.generated.messages import KfKind

    if hello.kf_kind == KfKind.CONSTANT:
        return _name(WEIGHT_KF_SCHEDULES, hello.kf_schedule)
    return _words(hello.kf_kind)


def _words(value) -> str:
    """An enumerator for people; a newer board may send a number that has no name here."""
    return value.name.lower().replace("_", " ") if hasattr(value, "name") else f"number {value}"


def _name(names: tuple[str, ...], index: int) -> str:
    return names[index] if index < len(names) else f"number {index}, unknown to this host"


def _is_bad(name: str, value) -> bool:
    """Counters that stand at zero on a healthy board."""
    healthy = (
        "uptime_s",
        "conversions",
        "settling_dropped",
        "stack_free_bytes",
        "cpu_busy_permille",
        "settings_saved",
    )
    return name not in healthy and value != 0
