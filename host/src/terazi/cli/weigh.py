# SPDX-License-Identifier: MIT
"""`terazi weigh`: a group whose first word is a verb, or else a capture."""

import importlib
import importlib.util

import typer
from typer.core import TyperGroup

# Each in a module of its own, weigh_VERB, which holds a function of its name.
VERBS = ["file", "static", "dynamic", "score"]
OF_A_FILE = "file"


class Weigh(TyperGroup):
    """`terazi weigh FILE` is short for `terazi weigh file FILE`. A verb goes before a file."""

    def resolve_command(self, ctx, args):
        if args and args[0] not in self.commands:
            args = [OF_A_FILE, *args]
        return super().resolve_command(ctx, args)


weigh = typer.Typer(
    cls=Weigh,
    no_args_is_help=True,
    rich_markup_mode="rich",
    help="How well it weighs: a capture beside class III (terazi weigh FILE), the chip's own chain "
    "on simulated loads (static, dynamic), its filters beside common ones (score).",
)


@weigh.callback()
def _group() -> None:
    """Keeps each a verb of its own, even the only one."""


def _add_verbs() -> None:
    for verb in VERBS:
        name = f"terazi.cli.weigh_{verb}"
        if importlib.util.find_spec(name) is not None:
            weigh.command(verb)(getattr(importlib.import_module(name), verb))


_add_verbs()
