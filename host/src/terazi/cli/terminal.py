# SPDX-License-Identifier: MIT
"""The terminal of terazi.calibration's dialogues, by rich: works over ssh, and in a pipe."""

from collections.abc import Callable, Sequence

from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from terazi.cli.keys import Keys
from terazi.errors import Aborted

STYLES = {"": "", "good": "green", "warn": "yellow", "bad": "bold red", "soft": "dim"}
ENTER = frozenset("\r\n")


class RichTerminal:
    """Speaks on one console, listens on standard input."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._live: Live | None = None

    def tell(self, text: str, *, tone: str = "") -> None:
        self.live("")
        self._console.print(text, style=STYLES[tone], markup=False, highlight=False)

    def table(self, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        self.live("")
        table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
        for heading in headings:
            table.add_column(heading, justify="left" if heading == headings[0] else "right")
        for row in rows:
            table.add_row(*row)
        self._console.print(table)

    def ask(self, question: str, default: str = "") -> str:
        self.live("")
        self._console.print(question, markup=False, highlight=False, end="")
        if default:
            self._console.print(f" [{default}]", style="dim", markup=False, end="")
        return self._line(" ") or default

    def choose(self, question: str, choices: dict[str, str]) -> str:
        self.live("")
        keys = list(choices)
        self._console.print(question, markup=False, highlight=False)
        for number, (key, words) in enumerate(choices.items(), 1):
            name = words if key.isdecimal() else f"{key}: {words}"
            self._console.print(f"  {number}  {name}", markup=False, highlight=False)
        while True:
            said = self._line("1> " if len(keys) == 1 else f"1-{len(keys)} [1]> ").strip().lower()
            if not said:
                return keys[0]
            if said.isdecimal() and 1 <= int(said) <= len(keys):
                return keys[int(said) - 1]
            begun = [key for key in keys if key.startswith(said)]
            if len(begun) == 1 and not said.isdecimal():
                return begun[0]
            self._console.print(f"1 to {len(keys)}, or a word's beginning", style="red")

    def pause(self, text: str, turn: Callable[[], str]) -> None:
        self.live("")
        self._console.print(text, style="bold", markup=False, highlight=False)
        with Keys() as keys:
            if not keys.is_there:
                self._line("")
                return
            try:
                while not ENTER.intersection(keys.pressed()):
                    self.live(turn())
            finally:
                self.live("")

    def live(self, text: str) -> None:
        if not text:
            if self._live is not None:
                self._live.stop()
                self._live = None
            return
        if not self._console.is_terminal:
            return
        if self._live is None:
            self._live = Live(console=self._console, auto_refresh=False, transient=True)
            self._live.start()
        self._live.update(Text(f"  {text}", style="cyan", no_wrap=True), refresh=True)

    def _line(self, prompt: str) -> str:
        try:
            return self._console.input(prompt, markup=False).strip()
        except EOFError:
            raise Aborted(
                "nobody answers: standard input has ended",
                remedy="Give what is asked for by options; --help lists them.",
            ) from None
