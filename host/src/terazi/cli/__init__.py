# SPDX-License-Identifier: MIT
"""The command `terazi`: one module a verb. What a verb needs, it imports when it is called."""

import importlib
import importlib.util

import typer
from typer.core import TyperGroup

from terazi.cli.common import errors
from terazi.errors import TeraziError

INTERRUPTED = 130  # 128 + SIGINT, as shells have it

# In the order in which a newcomer needs them. A verb's module holds a function of its name, or a
# group of verbs.
VERBS = [
    "ports",
    "flash",
    "info",
    "calibrate",
    "watch",
    "live",
    "tare",
    "set",
    "log",
    "replay",
    "report",
    "design",
    "weigh",
    "attitude",
    "walk",
]

EPILOG = (
    "Exit codes: 0 fine, 2 usage or missing tool, 3 port missing, 4 port busy, 5 port vanished, "
    "6 no answer, 7 other protocol version, 8 cannot write, 9 cannot read, 10 replay disagrees, "
    "11 flashing failed, 12 a design misses what was wished for, 13 calibration points contradict "
    "one another, 130 interrupted."
)


class Verbs(TyperGroup):
    """Turns faults that have a name into one clear line and an exit code."""

    def invoke(self, ctx):
        try:
            return super().invoke(ctx)
        except TeraziError as error:
            show_error(error)
            raise typer.Exit(error.exit_code) from None
        except KeyboardInterrupt:
            errors.print("interrupted", style="yellow")
            raise typer.Exit(INTERRUPTED) from None


def show_error(error: TeraziError) -> None:
    """One line for what happened, one for what to do."""
    errors.print("error: ", style="bold red", end="")
    errors.print(str(error), markup=False, highlight=False, soft_wrap=True)
    if error.remedy:
        errors.print(error.remedy, style="dim", markup=False, highlight=False, soft_wrap=True)


app = typer.Typer(
    cls=Verbs,
    name="terazi",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_show_locals=False,
    help="Weigh with an Arduino Uno: find the board, program it, record it, prove and see it.",
    epilog=EPILOG,
)


@app.callback(invoke_without_command=True)
def _program(
    version: bool = typer.Option(False, "--version", help="Print the version and end."),
) -> None:
    if version:
        from terazi import __version__

        print(f"terazi {__version__}")
        raise typer.Exit


def _add_verbs() -> None:
    for verb in VERBS:
        if importlib.util.find_spec(f"terazi.cli.{verb}") is not None:
            module = importlib.import_module(f"terazi.cli.{verb}")
            command = getattr(module, verb)
            if isinstance(command, typer.Typer):
                app.add_typer(command, name=verb)
            else:
                app.command(verb)(command)


_add_verbs()


def main() -> None:
    """Entry point of the command."""
    app()
