# SPDX-License-Identifier: MIT
"""`terazi log`."""

import signal
import time
from collections import deque
from pathlib import Path
from typing import Annotated

import typer
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table

from terazi.cli.common import (
    BAUD_DEFAULT,
    PORT_REST_S,
    BaudOption,
    PortArgument,
    errors,
    out,
    show_version,
)
from terazi.units import g_from_mg, s_from_us, show_bytes, show_duration, show_g

RATE_WINDOW_S = 2.0
SILENCE_S = 2.0  # without a sample for so long, the live line says so
POLL_S = 0.1
LIVE_PER_S = 8
ASKED_MOST = 3
IMU_MODE = "imu.mode"


def log(
    port: PortArgument = None,
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            help="The capture to write; CSV and Parquet are written beside it.",
            show_default=False,
        ),
    ] = ...,
    seconds: Annotated[
        float | None,
        typer.Option(help="Stop after so long; without it, ctrl-C stops.", min=0.0),
    ] = None,
    baud: BaudOption = BAUD_DEFAULT,
    imu: Annotated[
        bool,
        typer.Option(
            "--imu",
            help="The IMU's raw samples, too, from a new start of its chain on; one in imu.every.",
        ),
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite an older recording.")] = False,
) -> None:
    """Record the board: raw bytes as the source of truth, tables beside them. Resets the board.

    ctrl-C ends the recording cleanly; whatever ends it, all that came in until then is kept.

    [dim]Examples:[/]  terazi log -o weights.terazi
    terazi log /dev/ttyACM0 -o weights.terazi --seconds 60
    terazi set imu.every=1 uart.baud=500000, then terazi log --imu -o motion.terazi
    """
    from terazi.link import find_port
    from terazi.recorder import Recorder

    port = find_port(port)
    with Stop() as stop:
        recorder = Recorder(output, overwrite=force)
        try:
            with errors.status(f"waiting for {port} ..."):
                link = _open(port, baud, recorder)
                hello = link.hello()
            recorder.begin(port=port, baud=link.baud, age_s=link.now_s())
        except BaseException:
            recorder.abandon()
            raise
        stop.is_graceful = True
        where = f"Terazi {show_version(hello)} at {port}, recording to {output}"
        errors.print(where, markup=False, soft_wrap=True)
        if not seconds:
            errors.print("ctrl-C ends the recording", style="dim")
        with link:
            fault = _record(link, recorder, stop, seconds, imu)
        summary = recorder.finish(link.stream, link.now_s())
    _show_summary(summary)
    faults = [fault] if fault is not None else []
    faults += [one for one in summary.faults if one is not fault]
    for one in faults[1:]:
        errors.print(str(one), style="red", markup=False, soft_wrap=True)
    if faults:
        raise faults[0]


def _open(port: str, baud: int | None, recorder):
    """A link from whose first byte on all is recorded.

    Where the board's rate had to be found first, its start was missed: it is let start anew.
    """
    from terazi.link import BAUDS, open_link

    link = open_link(port, baud, on_bytes=recorder.on_bytes)
    link.hello()
    found = link.baud
    if baud is None and found != BAUDS[0]:
        link.close()
        recorder.forget()
        time.sleep(PORT_REST_S)
        link = open_link(port, found, on_bytes=recorder.on_bytes)
    return link


class Stop:
    """SIGINT and SIGTERM: an interruption at first, a wish once `is_graceful` is set."""

    def __init__(self) -> None:
        self.is_graceful = False
        self.is_wanted = False

    def __enter__(self) -> "Stop":
        self._before = {
            number: signal.signal(number, self._on_signal)
            for number in (signal.SIGINT, signal.SIGTERM)
        }
        return self

    def __exit__(self, *_exception) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _on_signal(self, _number, _frame) -> None:
        self.is_wanted = True
        if not self.is_graceful:
            raise KeyboardInterrupt


def _record(link, recorder, stop: Stop, seconds: float | None, imu: bool):
    """Record until the time is up or a signal comes; gives what went wrong, if anything."""
    from terazi.errors import TeraziError

    try:
        _ask_for_all(link, imu)
        begin_s = link.now_s()
        line = LiveLine(link, recorder, seconds)
        with line.shown():
            while not stop.is_wanted:
                left_s = POLL_S if seconds is None else begin_s + seconds - link.now_s()
                if left_s <= 0:
                    break
                for received in link.poll(min(POLL_S, left_s)):
                    recorder.add(received)
                    line.add(received)
                line.refresh(link.now_s() - begin_s)
    except TeraziError as error:
        for received in link.pending():
            recorder.add(received)
        return error
    return None


def _ask_for_all(link, imu: bool) -> None:
    """Samples as they come, and once settings and points, by which a replay verifies the mass.

    imu : raw samples of the IMU, too.
    """
    from terazi.control import Balance
    from terazi.control.settings import read_settings
    from terazi.errors import CommandRefused, NoAnswer
    from terazi.link.generated.messages import SetStream, StreamFlag
    from terazi.link.generated.settings import SETTINGS_BY_NAME
    from terazi.link.load import imu_advice

    everything = sum(StreamFlag) if imu else sum(StreamFlag) & ~StreamFlag.IMU
    # Attitudes may fill the line, so that there is no room for answers.
    asking = everything & ~(StreamFlag.ATTITUDE | StreamFlag.IMU)
    try:
        link.command(SetStream(mask=asking))
        settings = read_settings(link, SETTINGS_BY_NAME)
        if imu:
            for advice in imu_advice(settings, link.baud):
                errors.print(advice, style="yellow", markup=False, soft_wrap=True)
        for _attempt in range(ASKED_MOST):
            # Behind a frame that was lost no points hold that were told before it.
            lost = link.stream.frames_lost
            Balance(link).points()
            if link.stream.frames_lost == lost:
                break
        if imu:
            _begin_imu_anew(link, settings, everything)
        else:
            link.command(SetStream(mask=everything))
    except (CommandRefused, NoAnswer) as error:
        errors.print(f"{error}: a replay will not verify the mass", style="yellow", soft_wrap=True)


def _begin_imu_anew(link, settings: dict[str, int], mask: int) -> None:
    """Raw samples from the chain's first one on, so that a replay knows its state: it starts where
    its settings change, so that it is switched off, streamed, and switched on again."""
    from terazi.control.settings import apply_settings
    from terazi.link.generated.messages import SetStream

    if settings[IMU_MODE]:
        apply_settings(link, {IMU_MODE: 0})
    link.command(SetStream(mask=mask))
    apply_settings(link, {IMU_MODE: settings[IMU_MODE]})


class LiveLine:
    """One line on a terminal: time, rate, weight, lost frames. Elsewhere it keeps quiet."""

    def __init__(self, link, recorder, seconds: float | None) -> None:
        from terazi.link.generated.messages import SampleFlag, WeightFlag

        self._at_rail = SampleFlag.AT_RAIL
        self._stable = WeightFlag.STABLE
        self._link = link
        self._recorder = recorder
        self._seconds = seconds
        self._recent: deque = deque()  # (device_us, conversion) of the last RATE_WINDOW_S
        self._sample = None
        self._sample_host_s = link.now_s()
        self._state = ""
        self._live = Live(console=errors, auto_refresh=False, transient=True)
        self._shown_s = -1.0

    def shown(self) -> Live:
        return self._live

    def add(self, received) -> None:
        from terazi.link.generated.messages import Sample, Status

        message = received.message
        if isinstance(message, Status):
            self._state = getattr(message.converter_state, "name", "").lower().replace("_", " ")
        if not isinstance(message, Sample):
            return
        self._sample = message
        self._sample_host_s = received.host_s
        now = (received.device_us, message.conversion, received.boot)
        if self._recent and self._recent[-1][2] != received.boot:
            self._recent.clear()
        self._recent.append(now)
        while s_from_us(now[0] - self._recent[0][0]) > RATE_WINDOW_S:
            self._recent.popleft()

    def refresh(self, elapsed_s: float) -> None:
        if not errors.is_terminal or elapsed_s - self._shown_s < 1 / LIVE_PER_S:
            return
        self._shown_s = elapsed_s
        self._live.update(self._line(elapsed_s), refresh=True)

    def _line(self, elapsed_s: float) -> Table:
        line = Table.grid(padding=(0, 2))
        cells = [show_duration(elapsed_s)]
        if self._seconds:
            cells.append(ProgressBar(self._seconds, min(elapsed_s, self._seconds), width=10))
        silent_s = self._link.now_s() - self._sample_host_s
        if silent_s > SILENCE_S:
            why = f" (converter {self._state})" if self._state else ""
            cells.append(f"[bold red]no samples for {silent_s:.0f} s{why}[/]")
        elif self._sample is not None:
            cells.append(self._rate())
            cells.append(f"[bold]{show_g(g_from_mg(self._sample.net_mg)):>12}[/]")
            is_stable = self._sample.weight_flags & self._stable
            cells.append("[green]stable[/]" if is_stable else "[yellow]moving[/]")
            if self._sample.flags & self._at_rail:
                cells.append("[bold red]at the converter's rail[/]")
        lost = self._link.stream.frames_lost
        cells.append(f"[red]{lost} frames lost[/]" if lost else "[green]0 frames lost[/]")
        cells.append(f"[dim]{self._recorder.samples} samples[/]")
        line.add_row(*cells)
        return line

    def _rate(self) -> str:
        first, last = self._recent[0], self._recent[-1]
        conversions = (last[1] - first[1]) % (1 << 16)
        if last[0] <= first[0] or not conversions:
            return "... SPS"
        return f"{conversions / s_from_us(last[0] - first[0]):.2f} SPS"


def _show_summary(summary) -> None:
    def show(name: str, value: str, style: str = "") -> None:
        out.print(f"{name:<18}{value}", style=style, markup=False, soft_wrap=True)

    def show_count(name: str, count: int) -> None:
        show(name, str(count), "red" if count else "")

    show("recorded", f"{summary.samples} samples in {show_duration(summary.duration_s)}")
    if summary.attitudes or summary.imu_samples:
        show("of the IMU", f"{summary.imu_samples} raw samples, {summary.attitudes} attitudes")
    show_count("frames lost", summary.frames_lost)
    show_count("frames corrupt", summary.frames_bad)
    show_count("conversions lost", summary.conversions_lost)
    if summary.restarts:
        show_count("device restarts", summary.restarts)
    show("capture", f"{summary.path} ({show_bytes(summary.size_bytes)})")
    for number, path in enumerate(summary.tables):
        show("" if number else "tables", str(path))
    if not summary.samples:
        errors.print(
            "No sample came: is the HX711 wired, and has it power? `terazi info` shows its state.",
            style="yellow",
        )
    for note in summary.notes:
        errors.print(note, style="yellow", soft_wrap=True)
