# SPDX-License-Identifier: MIT
"""`terazi attitude`: a group whose first word is a verb, or else a recording."""

import importlib

import typer
from typer.core import TyperGroup

# Each in a module of its own, attitude_VERB, which holds a function of its name.
VERBS = ["file", "allan", "score"]
OF_A_FILE = "file"


class Attitude(TyperGroup):
    """`terazi attitude FILE` is short for `... attitude file FILE`. A verb goes before a file."""

    def resolve_command(self, ctx, args):
        if args and args[0] not in self.commands:
            args = [OF_A_FILE, *args]
        return super().resolve_command(ctx, args)


attitude = typer.Typer(
    cls=Attitude,
    no_args_is_help=True,
    rich_markup_mode="rich",
    help="Where a board points to: a recording's angles, rates, bias and rest (terazi attitude "
    "FILE), the noise of its sensors (allan), the chip's filter on trials whose orientation is "
    "known (score).",
)


@attitude.callback()
def _group() -> None:
    """Keeps each a verb of its own, even the only one."""


def _add_verbs() -> None:
    for verb in VERBS:
        module = importlib.import_module(f"terazi.cli.attitude_{verb}")
        attitude.command(verb)(getattr(module, verb))


_add_verbs()
