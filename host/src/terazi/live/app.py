# SPDX-License-Identifier: MIT
"""The screen of `terazi live`: 80 columns by 24 lines are enough, and a slow line, too."""

from __future__ import annotations

from rich.text import Text
from textual.app import App, ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Digits, Footer, Static

from terazi.live import parts
from terazi.live.session import Session

DRAWN_PER_S = 10


class FaultScreen(ModalScreen):
    """The faults that hold, what each means, and what to do."""

    CSS = """
    FaultScreen { align: center middle; }
    #faults { width: 76; height: auto; max-height: 20; border: round $error; padding: 0 1; }
    """
    BINDINGS = (Binding("f,escape,q", "dismiss", "back"),)

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session

    def compose(self) -> ComposeResult:
        with VerticalScroll(id="faults") as box:
            box.border_title = "faults   (f: back)"
            yield Static(id="list")

    def on_mount(self) -> None:
        self._draw()
        self.set_interval(0.5, self._draw)

    def _draw(self) -> None:
        self.query_one("#list", Static).update(parts.fault_list(self._session))


class LiveApp(App):
    """Weight and attitude; keys give the orders."""

    ENABLE_COMMAND_PALETTE = False
    CSS = """
    Screen { layout: vertical; }
    #weight { height: 6; border: round $primary; padding: 0 1; }
    #digits { height: 3; width: 1fr; }
    #attitude { height: 10; border: round $primary; padding: 0 1; }
    #angles { width: 1fr; height: 8; }
    #bubble { width: 23; height: 8; }
    #health, #fault, #imu { height: 1; }
    #said { height: auto; max-height: 2; }
    #events { height: 1fr; min-height: 2; }
    """
    BINDINGS = (
        Binding("t", "order('tare')", "tare"),
        Binding("z", "order('zero')", "zero"),
        Binding("c", "order('clear')", "clear tare"),
        Binding("x", "order('text')", "text"),
        Binding("r", "order('record')", "record"),
        Binding("f", "faults", "faults"),
        Binding("q", "quit", "quit"),
    )

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        self._digits = Digits("", id="digits")
        names = ("marks", "angles", "bubble", "imu", "health", "fault", "events", "said")
        self._parts = {name: Static(id=name) for name in names}

    def compose(self) -> ComposeResult:
        with Vertical(id="weight") as box:
            box.border_title = f"Terazi at {self._session.link.name}"
            yield self._digits
            yield self._parts["marks"]
        with Horizontal(id="attitude") as box:
            box.border_title = "attitude"
            yield self._parts["angles"]
            yield self._parts["bubble"]
        for name in ("imu", "health", "fault", "events", "said"):
            yield self._parts[name]
        yield Footer()

    def on_mount(self) -> None:
        self._draw()
        self.set_interval(1 / DRAWN_PER_S, self._draw)

    def _draw(self) -> None:
        session = self._session
        if session.fault is not None:
            self.exit(return_code=1)
            return
        told = session.lines if session.is_text else session.watch.events
        newest = list(told)[-self._events_room :]
        words, is_bad = session.said
        self._digits.update(parts.weight_digits(session))
        for name, content in (
            ("marks", parts.weight_words(session)),
            ("angles", parts.angles(session)),
            ("bubble", parts.bubble(session)),
            ("imu", self._cut(parts.imu_line(session))),
            ("health", self._cut(parts.health(session))),
            ("fault", self._cut(parts.fault_line(session))),
            ("events", Text("\n").join(self._cut(Text(one)) for one in newest)),
            ("said", Text(words, style="bold red" if is_bad else "green")),
        ):
            self._parts[name].update(content)

    def _cut(self, line: Text) -> Text:
        """A line that keeps to one."""
        line.truncate(self.size.width, overflow="ellipsis")
        return line

    @property
    def _events_room(self) -> int:
        """Lines that there are room for: the newest are shown."""
        return max(self._parts["events"].size.height, 1)

    def action_order(self, name: str) -> None:
        """A key's order to the board."""
        self._session.order(name)

    def action_faults(self) -> None:
        """Show the list of faults."""
        self.push_screen(FaultScreen(self._session))
