# SPDX-License-Identifier: MIT
"""`terazi watch`."""

import json
from typing import Annotated

import typer
from rich.console import Group
from rich.live import Live
from rich.text import Text

from terazi.cli.board import board
from terazi.cli.common import BAUD_DEFAULT, BaudOption, PortArgument, out
from terazi.cli.keys import Keys

DRAWN_PER_S = 10
TURN_S = 0.05
COMMAND_WAIT_S = 5.0
KEYS_SHOWN = "t tare   z zero   c clear the tare   q quit"


def watch(
    port: PortArgument = None,
    seconds: Annotated[
        float | None,
        typer.Option(help="End after so long; without it, q or ctrl-C ends.", min=0.0),
    ] = None,
    baud: BaudOption = BAUD_DEFAULT,
    as_json: Annotated[
        bool, typer.Option("--json", help="One JSON object a line for each message that comes.")
    ] = False,
) -> None:
    """Show what lies on the scale, live, with all that it tells, and how the board lies where it
    has an IMU. Resets the board.

    Keys: t tares, z sets zero, c clears the tare, q quits. Where standard output is no terminal,
    a line whenever something changes.

    [dim]Examples:[/]  terazi watch      terazi watch --seconds 60 > weights.txt
    """
    from terazi.control.display import Watch
    from terazi.link.generated.messages import StreamFlag

    with board(port, baud) as link:
        state = Watch(link)
        state.balance.quiet_stream(StreamFlag.ATTITUDE)
        screen = _Json() if as_json else _Screen(link.name) if out.is_terminal else _Lines()
        state.on_told = screen.take
        try:
            with screen, Keys() as keys:
                _run(link, state, screen, keys, seconds)
        except KeyboardInterrupt:
            pass  # the usual end of it


def _run(link, state, screen, keys, seconds: float | None) -> None:
    end_s = None if seconds is None else link.now_s() + seconds
    while end_s is None or link.now_s() < end_s:
        state.balance.follow(TURN_S)
        screen.draw(state, keys.is_there)
        for key in keys.pressed():
            if key in "qQ\x04":
                return
            _obey(key, state, screen, keys)


def _obey(key: str, state, screen, keys) -> None:
    """A key's command; what comes of it is told on the screen, and never ends the watch."""
    from terazi.errors import CommandRefused, NoAnswer

    balance = state.balance
    does = {
        "t": ("tare", balance.tare),
        "z": ("zero", balance.zero),
        "c": ("clear the tare", lambda _wait_s, _show: balance.clear()),
    }.get(key.lower())
    if does is None:
        return
    name, command = does

    def show(_balance) -> None:
        screen.say(f"{name}: waiting for the load to stand still ...")
        screen.draw(state, keys.is_there)

    try:
        command(COMMAND_WAIT_S, show)
    except (CommandRefused, NoAnswer) as error:
        screen.say(f"{name}: {error}", is_bad=True)
    else:
        screen.say(f"{name}: done")


class _Lines:
    """Plain lines for a pipe: the weight when its display or marks change, and events; the
    attitude when it has turned, once a second at most."""

    def __init__(self) -> None:
        self._before = ""
        self._attitude, self._attitude_us = "", 0

    def __enter__(self):
        return self

    def __exit__(self, *_exception) -> None:
        pass

    def take(self, received, events: list[str]) -> None:
        from terazi.control.display import marks, shown
        from terazi.link.generated.messages import Attitude, Weight
        from terazi.units import s_from_us

        for line in events:
            print(line, flush=True)
        weight = received.message
        if isinstance(weight, Weight):
            words = f"{shown(weight):>14}  {', '.join(marks(weight))}"
            if words != self._before:
                self._before = words
                print(f"{s_from_us(received.device_us):10.3f} s  {words}", flush=True)

        if isinstance(received.message, Attitude):
            self._take_attitude(received)

    def _take_attitude(self, received) -> None:
        from terazi.control.inertial import attitude_words
        from terazi.units import US_PER_S, s_from_us

        if self._attitude and received.device_us - self._attitude_us < US_PER_S:
            return
        self._attitude_us = received.device_us
        words = attitude_words(received.message)
        if words != self._attitude:
            self._attitude = words
            print(f"{s_from_us(received.device_us):10.3f} s  {words}", flush=True)

    def draw(self, _state, _has_keys: bool) -> None:
        """What there is to show was printed as it came."""

    def say(self, words: str, *, is_bad: bool = False) -> None:
        """Only keys ask for anything, and there are none."""


class _Json(_Lines):
    """Each message as one line of JSON."""

    def take(self, received, _events: list[str]) -> None:
        from terazi.link.plain import plain_message

        name = type(received.message).__name__.lower()
        told = {"message": name, "device_us": received.device_us, "boot": received.boot}
        print(json.dumps(told | plain_message(received.message)), flush=True)


class _Screen:
    """A few lines that are drawn in place; they fit in 80 x 24."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._said = Text("")
        self._drawn_s = -1.0
        self._live = Live(console=out, auto_refresh=False, transient=False)

    def __enter__(self):
        self._live.start()
        return self

    def __exit__(self, *_exception) -> None:
        self._live.stop()

    def take(self, _received, _events: list[str]) -> None:
        """The next drawing shows it."""

    def say(self, words: str, *, is_bad: bool = False) -> None:
        self._said = Text(words, style="bold red" if is_bad else "green")

    def draw(self, state, has_keys: bool) -> None:
        now_s = state.balance.link.now_s()
        if now_s - self._drawn_s < 1 / DRAWN_PER_S:
            return
        self._drawn_s = now_s
        self._live.update(Group(*self._content(state, has_keys)), refresh=True)

    def _content(self, state, has_keys: bool) -> list[Text]:
        rows = [self._weight(state), *self._attitude(state)]
        rows += [*self._health(state), *self._counts(state)]
        rows += [Text(line, style="dim", no_wrap=True) for line in state.events]
        if self._said:
            rows.append(self._said)
        rows.append(Text(KEYS_SHOWN if has_keys else "ctrl-C ends", style="dim"))
        return rows

    def _weight(self, state) -> Text:
        from terazi.control.balance import SILENCE_S
        from terazi.control.display import marks, shown

        balance = state.balance
        if balance.weight is None or balance.silent_s > SILENCE_S:
            return Text(f"no weight for {balance.silent_s:.0f} s", style="bold red")
        words = marks(balance.weight)
        row = Text(f"{shown(balance.weight):>14}  ", style="bold")
        row.append(words[0], style="green" if words[0] == "stable" else "yellow")
        for word in words[1:]:
            row.append(f"   {word}", style="bold red" if word in ("over", "under") else "cyan")
        return row

    def _attitude(self, state) -> list[Text]:
        from terazi.control import inertial
        from terazi.link.generated.messages import ImuState

        if state.attitude is None:
            return []
        status = state.imu_status
        if status is not None and status.state != ImuState.RUNNING:
            return [Text(f"  IMU {inertial.state_words(status)}", style="bold red")]
        row = Text(f"  {inertial.attitude_words(state.attitude)}", no_wrap=True)
        flags = state.attitude.flags
        for words in inertial.flag_words(flags & ~inertial.ALARMING):
            row.append(f"   {words}", style="cyan")
        for words in inertial.flag_words(flags & inertial.ALARMING):
            row.append(f"   {words}", style="bold red")
        return [row]

    def _health(self, state) -> list[Text]:
        from terazi.control import faults
        from terazi.control.display import temperature_deg_c

        weight = state.balance.weight
        words = [self._name, f"{state.rate_hz:.2f} SPS" if state.rate_hz else "rate not known yet"]
        degrees = temperature_deg_c(weight) if weight else None
        if degrees is not None:
            words.append(f"{degrees:.1f} °C")
        if lost := state.balance.link.stream.frames_lost:
            words.append(f"{lost} frames lost")
        rows = [Text("  ".join(words), style="dim", no_wrap=True)]
        for name, what, remedy in faults.explained(state.faults):
            rows.append(Text(f"fault: {name}: {what}", style="bold red"))
            rows.append(Text(f"  {remedy}", style="yellow"))
        return rows

    def _counts(self, state) -> list[Text]:
        from terazi.control.display import product_words

        counts = state.counts
        if counts.last is None:
            return []
        classes = ", ".join(f"class {key}: {n}" for key, n in sorted(counts.classes.items()))
        row = f"{counts.weighed} weighed, {counts.unweighed} not, {counts.per_minute:.1f} a minute"
        return [Text(product_words(counts.last), style="bold"), Text(f"{row}; {classes}")]
