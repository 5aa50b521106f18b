# SPDX-License-Identifier: MIT
"""What a dialogue needs of a terminal. The real one is terazi.cli.terminal; tests bring their own.

Time goes by in `pause` only through `turn`, which lets a link be polled meanwhile: so a dialogue
runs in lock step with a simulated board as it does with a person.
"""

from collections.abc import Callable, Sequence
from typing import Protocol


class Terminal(Protocol):
    """Any of these may raise KeyboardInterrupt: ctrl-C."""

    def tell(self, text: str, *, tone: str = "") -> None:
        """One or more lines. tone: "" plain, "good", "warn", "bad", "soft"."""

    def table(self, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """Columns, all but the first aligned to the right."""

    def ask(self, question: str, default: str = "") -> str:
        """A line typed; empty input gives the default."""

    def choose(self, question: str, choices: dict[str, str]) -> str:
        """One of the keys; each says what it does. The first is the default."""

    def pause(self, text: str, turn: Callable[[], str]) -> None:
        """Show text until Enter; meanwhile call `turn` over and over, and show what it gives."""

    def live(self, text: str) -> None:
        """A line in place of the live line before; "" takes it away."""
