# SPDX-License-Identifier: MIT
"""What the verbs share: where they write to, and the options that several of them take.

Results go to standard output, progress and errors to standard error, so that pipes stay clean.
"""

from typing import Annotated

import typer
from rich.console import Console

from terazi.units import hz_from_q16

BAUD_DEFAULT: int | None = None  # whichever the board speaks
PORT_REST_S = 0.3  # between closing a port and opening it again: the USB bridge must see both

out = Console(highlight=False)
errors = Console(stderr=True, highlight=False)

PortArgument = Annotated[
    str | None,
    typer.Argument(
        help="Serial port, for example /dev/ttyACM0 or COM3; a link to one will do. "
        "May be left out when just one board is plugged in.",
        envvar="TERAZI_PORT",
        show_default=False,
    ),
]
BaudOption = Annotated[
    int | None,
    typer.Option(
        help="Bits a second on the wire; without it those that the board may speak are tried.",
        min=1,
        show_default=False,
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object, nothing else.")]


def show_rate(rate_hz_q16: int) -> str:
    """A converter rate as the device measured it."""
    return f"{hz_from_q16(rate_hz_q16):.2f} SPS" if rate_hz_q16 else "not known yet"


def show_version(hello) -> str:
    """The firmware's version, with its build where there is one."""
    version = f"{hello.version_major}.{hello.version_minor}.{hello.version_patch}"
    return f"{version} (build {hello.build:08x})" if hello.build else f"{version} (unclean build)"
