# SPDX-License-Identifier: MIT
"""Follows a board in a thread of its own, and obeys: the screen reads, and gives orders."""

from __future__ import annotations

import queue
import threading
from collections import deque
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from terazi.control.balance import SILENCE_S
from terazi.control.display import Watch
from terazi.errors import TeraziError
from terazi.link import Link, Received
from terazi.link.generated.messages import (
    Attitude,
    AttitudeFlag,
    GetInfo,
    ImuStatus,
    SetStream,
    SetTextMode,
    StreamFlag,
)

TURN_S = 0.05
COMMAND_WAIT_S = 5.0
LINES_KEPT = 200
RATE_WINDOW = 100  # ATTITUDEs over which their rate is measured
SHOWN_STREAM = StreamFlag.WEIGHT | StreamFlag.STATUS | StreamFlag.EVENT | StreamFlag.ATTITUDE
RECORDED_STREAM = SHOWN_STREAM | StreamFlag.SAMPLE
TEXT_STREAM = RECORDED_STREAM  # a text line stands for a SAMPLE, and comes where that would
ASKING_STREAM = RECORDED_STREAM & ~StreamFlag.ATTITUDE  # attitudes may fill the line
# They tell what happened since the ATTITUDE before, too shortly for an eye.
MOMENTARY = AttitudeFlag.GAP | AttitudeFlag.RAILED | AttitudeFlag.RESTARTED
MOMENT_S = 2.0
ATTITUDE_SILENCE_S = 1.0
TOO_NARROW = (
    "attitudes fill the line, so that no weight came: they are left out. "
    "More room: terazi set uart.baud=500000"
)


class Session:
    """A board's newest messages, and what was asked of it.

    `watch`, `attitude`, `imu`, `lines` and `said` are read by the screen at any time; everything
    that touches the link runs in the thread. record_to gives the path of the next recording.
    """

    def __init__(self, link: Link, *, record_to: Callable[[], Path] | None = None) -> None:
        self.link = link
        self.watch = Watch(link)
        self.watch.on_told = self._take
        self.attitude: Received | None = None
        self.imu: ImuStatus | None = None
        self.lines: deque[str] = deque(maxlen=LINES_KEPT)  # of text mode
        self.is_text = False
        self.said = ("", False)  # words, and whether they are bad news
        self.fault: TeraziError | None = None  # what ended it
        self.is_narrow = False  # the line has no room for attitudes beside the weight
        self.recorder = None
        self.recorded: list[str] = []  # what came of each recording, in words
        self._moments: dict[AttitudeFlag, float] = {}  # host_s when told last
        self._record_to = record_to or _path_of_now
        self._orders: queue.Queue[str] = queue.Queue()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._stamps: deque[int] = deque(maxlen=RATE_WINDOW)
        self._rest_of_line = b""

    def __enter__(self) -> Session:
        self._thread.start()
        return self

    def __exit__(self, *_exception) -> None:
        self._stop.set()
        self._thread.join()

    @property
    def has_attitude(self) -> bool:
        """Whether one has come of late."""
        newest = self.attitude
        return newest is not None and self.link.now_s() - newest.host_s <= ATTITUDE_SILENCE_S

    @property
    def attitude_rate_hz(self) -> float:
        """How often ATTITUDE comes; 0 where it does not."""
        stamps = list(self._stamps)
        if len(stamps) < 2 or stamps[-1] == stamps[0] or not self.has_attitude:
            return 0.0
        return 1e6 * (len(stamps) - 1) / (stamps[-1] - stamps[0])

    @property
    def attitude_flags(self) -> int:
        """Of the newest ATTITUDE, and what has happened within MOMENT_S."""
        flags, now_s = self.attitude.message.flags, self.link.now_s()
        for flag, told_s in self._moments.items():
            if now_s - told_s < MOMENT_S:
                flags |= flag
        return flags

    def order(self, name: str) -> None:
        """tare, zero, clear, text, record: done as soon as what was ordered before is done."""
        self._orders.put(name)

    def _run(self) -> None:
        try:
            self._stream()
            boot = self.watch.restarts
            while not self._stop.is_set():
                self.watch.balance.follow(TURN_S)
                if self.watch.restarts != boot:  # it has forgotten what it was told
                    boot = self.watch.restarts
                    self.is_text = self.is_narrow = False
                    self._hook()
                    self._stream()
                self._make_room()
                while not self._orders.empty():
                    self._obey(self._orders.get())
        except TeraziError as error:  # the port is gone
            self.fault = error
        finally:
            self._end_recording()

    def _stream(self, mask: StreamFlag | None = None) -> None:
        """Ask for this, or for what is needed now."""
        if mask is None:
            mask = SHOWN_STREAM if self.recorder is None else RECORDED_STREAM
            mask |= TEXT_STREAM if self.is_text else 0
            mask &= ~StreamFlag.ATTITUDE if self.is_narrow else mask
        self.link.command(SetStream(mask=int(mask)))

    def _make_room(self) -> None:
        """The weight comes first where the line cannot carry both."""
        if self.is_narrow or self.is_text or self.watch.balance.silent_s < SILENCE_S:
            return
        if not self.has_attitude:
            return
        self.is_narrow = True
        self._stream()
        self._say(TOO_NARROW, is_bad=True)

    def _say(self, words: str, *, is_bad: bool = False) -> None:
        self.said = (words, is_bad)

    def _obey(self, name: str) -> None:
        from terazi.errors import CannotWrite, CommandRefused, NoAnswer, UsageError

        does = {
            "tare": self._tare,
            "zero": self._zero,
            "clear": self.watch.balance.clear,
            "text": self._toggle_text,
            "record": self._toggle_recording,
        }[name]
        try:
            words = does()
        except (CommandRefused, NoAnswer, CannotWrite, UsageError) as error:
            self._say(f"{name}: {error}", is_bad=True)
        else:
            self._say(words if isinstance(words, str) else f"{name}: done")

    def _tare(self) -> None:
        self.watch.balance.tare(COMMAND_WAIT_S, self._waiting("tare"))

    def _zero(self) -> None:
        self.watch.balance.zero(COMMAND_WAIT_S, self._waiting("zero"))

    def _waiting(self, name: str):
        return lambda _balance: self._say(f"{name}: waiting for the load to stand still ...")

    def _toggle_text(self) -> str:
        self.link.command(SetTextMode(on=0 if self.is_text else 1))
        self.is_text = not self.is_text
        self._hook()
        self._stream()
        return "text: lines as a plotter sees them" if self.is_text else "text: frames again"

    def _toggle_recording(self) -> str:
        if self.recorder is None:
            return self._begin_recording()
        return self._end_recording()

    def _begin_recording(self) -> str:
        from terazi.control import Balance
        from terazi.control.settings import read_settings
        from terazi.link.generated.settings import SETTINGS_BY_NAME
        from terazi.recorder import Recorder

        path = self._record_to()
        recorder = Recorder(path)
        recorder.begin(port=self.link.name, baud=self.link.baud or 0, age_s=self.link.now_s())
        self.recorder = recorder
        self._hook()
        # A capture begins with who speaks, and with what a replay must know.
        self._say(f"record: asking for the settings, into {path} ...")
        self._stream(ASKING_STREAM)
        self.link.request(GetInfo())
        read_settings(self.link, SETTINGS_BY_NAME)
        Balance(self.link).points()
        self._stream()
        return f"record: into {path}"

    def _end_recording(self) -> str:
        recorder, self.recorder = self.recorder, None
        self._hook()
        if recorder is None:
            return ""
        for received in self.link.pending():
            recorder.add(received)
        summary = recorder.finish(self.link.stream, self.link.now_s())
        words = f"{summary.samples} samples in {summary.path}"
        if summary.faults:
            words = f"{summary.faults[0]}; {words}"
        self.recorded.append(words)
        if self.fault is None and not self._stop.is_set():
            self._stream()
        return f"record: {words}"

    def _hook(self) -> None:
        """Who hears the bytes: the recording, the lines of text mode."""
        self.link.on_bytes = self._on_bytes if self.recorder or self.is_text else None

    def _on_bytes(self, host_s: float, data: bytes) -> None:
        if self.recorder is not None:
            self.recorder.on_bytes(host_s, data)
        if self.is_text:
            *whole, self._rest_of_line = (self._rest_of_line + data).split(b"\n")
            words = (line.strip(b"\r\0").decode("ascii", "replace") for line in whole)
            self.lines.extend(line for line in words if line)

    def _take(self, received: Received, _events: list[str]) -> None:
        message = received.message
        if isinstance(message, Attitude):
            if self.attitude is not None and self.attitude.boot != received.boot:
                self._stamps.clear()
            self.attitude = received
            for flag in MOMENTARY:
                if message.flags & flag:
                    self._moments[flag] = received.host_s
            self._stamps.append(received.device_us)
        elif isinstance(message, ImuStatus):
            self.imu = message
        if self.recorder is not None:
            self.recorder.add(received)


def _path_of_now() -> Path:
    return Path(f"{datetime.now():%Y%m%d-%H%M%S}.terazi")
