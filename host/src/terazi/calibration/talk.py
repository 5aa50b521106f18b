# SPDX-License-Identifier: MIT
"""What the dialogues say and ask over and over: masses, findings, the weight as it is now."""

from collections.abc import Callable

from terazi.calibration.points import Finding
from terazi.calibration.terminal import Terminal
from terazi.control.balance import Balance
from terazi.control.quantities import parse_mass_mg, show_mass
from terazi.errors import Aborted, CommandRefused, UsageError
from terazi.link.generated.messages import Weight, WeightFlag
from terazi.units import g_from_mg

ABORT = "end; the scale stays as it was"


def aborted() -> Aborted:
    """What a wish to end raises."""
    return Aborted("calibration aborted; the scale is as it was")


def live_words(balance: Balance) -> str:
    """The weight as it is now, for a live line."""
    weight = balance.weight
    if weight is None:
        return "no weight yet"
    words = show_mass(weight.net_mg)
    if weight.weight_flags & WeightFlag.STABLE:
        return f"{words}  stable"
    return f"{words}  moves by {show_mass(balance.spread_mg)}"


class Talk:
    """A terminal beside a scale: whatever is asked, the scale goes on being followed after it."""

    def __init__(self, balance: Balance, terminal: Terminal) -> None:
        self.balance, self.terminal = balance, terminal
        self.tell = terminal.tell

    def show(self, balance: Balance) -> None:
        """The live line, while something is waited for."""
        self.terminal.live(live_words(balance))

    def tell_error(self, error: CommandRefused | UsageError | Finding, tone: str = "bad") -> None:
        """What is wrong, and what to do."""
        text = error.text if isinstance(error, Finding) else str(error)
        self.tell(text[0].upper() + text[1:], tone=tone)
        if error.remedy:
            self.tell(error.remedy, tone="soft")

    def ask_mass(
        self, question: str, default_mg: int, why_not: Callable[[int], str] = lambda _mg: ""
    ) -> int:
        """A mass typed until nothing speaks against it; in gram without a unit."""
        while True:
            text = self.terminal.ask(question, f"{g_from_mg(default_mg):.10g}g")
            self.balance.fresh()
            try:
                mass_mg = parse_mass_mg(text)
            except UsageError as error:
                self.tell_error(error)
                continue
            if not (why := why_not(mass_mg)):
                return mass_mg
            self.tell(why, tone="bad")

    def ask_count(self, question: str, default: int, least: int, most: int) -> int:
        """A number typed."""
        while True:
            text = self.terminal.ask(question, str(default))
            self.balance.fresh()
            if text.isdecimal() and least <= int(text) <= most:
                return int(text)
            self.tell(f"a number from {least} to {most}", tone="bad")

    def choose(self, question: str, choices: dict[str, str]) -> str:
        """One of the choices; "abort" ends the dialogue."""
        chosen = self.terminal.choose(question, choices)
        self.balance.fresh()
        if chosen == "abort":
            raise aborted()
        return chosen

    def put_on(self, what: str) -> None:
        """Ask for a load and wait for Enter; meanwhile the weight is shown."""

        def turn() -> str:
            self.balance.follow()
            return live_words(self.balance)

        self.terminal.pause(f"{what}, then press Enter.", turn)
        self.balance.fresh()

    def wait_stable(self, wait_s: float) -> Weight:
        """The first stable weight, with the live line meanwhile."""
        try:
            return self.balance.wait_stable(wait_s, self.show)
        finally:
            self.terminal.live("")
