# SPDX-License-Identifier: MIT
"""Opening a board for the verbs that talk with it."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

from terazi.cli.common import errors

WaitOption = Annotated[
    float, typer.Option(help="Seconds to wait until the load stands still.", min=0.0)
]


@contextmanager
def board(port: str | None, baud: int | None) -> Iterator:
    """A link to the board at the port, which has said who it is.

    baud None: the rate is found out.
    """
    from terazi.link import find_port, open_link

    port = find_port(port)
    with errors.status(f"waiting for {port} ..."):
        link = open_link(port, baud)
        try:
            link.hello()
        except BaseException:
            link.close()
            raise
    with link:
        yield link
