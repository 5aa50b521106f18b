# SPDX-License-Identifier: MIT
"""A scale at the other end of a link: its weight as it comes, waiting for it, and its commands."""

from collections import deque
from collections.abc import Callable

from terazi.control import faults
from terazi.control.quantities import show_mass
from terazi.errors import CannotWrite, CommandRefused, NoAnswer
from terazi.link import Link, Received
from terazi.link.generated.messages import (
    Ack,
    Fault,
    FaultFlag,
    GetPoint,
    Point,
    Result,
    SetStream,
    SettingsState,
    Status,
    StreamFlag,
    Tare,
    TareClear,
    Weight,
    WeightFlag,
    Zero,
)
from terazi.units import US_PER_S

SPREAD_S = 1.0  # over which a movement is told
SILENCE_S = 2.0  # without a WEIGHT for so long, something is wrong: they come 10 a second
TURN_S = 0.1
SAVED_S = 10.0  # 260 bytes of 3.4 ms each take 0.9 s
POINTS_MAX = 8
QUIET = StreamFlag.WEIGHT | StreamFlag.STATUS | StreamFlag.EVENT

Show = Callable[["Balance"], None]


class Balance:
    """Follows the WEIGHTs of a link, and obeys. `weight` is the newest, None before the first."""

    def __init__(self, link: Link) -> None:
        self.link = link
        self.weight: Weight | None = None
        self.faults = FaultFlag(0)  # as the newest message has it
        self._recent: deque[tuple[int, int]] = deque()  # (device_us, net_mg) of SPREAD_S
        self._boot = 0
        self._heard_s = link.now_s()
        self._awaited = 0  # id of the command whose ACK makes older weights worthless
        self.on_received: Callable[[Received], None] = lambda _received: None

    def quiet_stream(self, more: StreamFlag = QUIET) -> None:
        """No SAMPLE, nothing of the IMU: a slow line, and a person who thinks long, lose nothing.

        more : what is wanted nevertheless.
        """
        self.link.command(SetStream(mask=QUIET | more))

    def take(self, received: Received) -> None:
        """Note a message that came in, and hand it on."""
        message = received.message
        if isinstance(message, (Weight, Status, Fault)):
            self.faults = message.faults
        if isinstance(message, Weight):
            self._take_weight(message, received)
        elif isinstance(message, Ack) and (message.command, message.result) == (
            self._awaited,
            Result.OK,
        ):
            self._forget()
        self.on_received(received)

    def _take_weight(self, message: Weight, received: Received) -> None:
        if received.boot != self._boot:
            self._boot = received.boot
            self._recent.clear()
        self.weight = message
        self._heard_s = received.host_s
        self._recent.append((received.device_us, message.net_mg))
        while received.device_us - self._recent[0][0] > SPREAD_S * US_PER_S:
            self._recent.popleft()

    def follow(self, seconds: float = TURN_S) -> None:
        """Let time go by and note what comes."""
        end_s = self.link.now_s() + seconds
        while (left_s := end_s - self.link.now_s()) > 0:
            for received in self.link.poll(left_s):
                self.take(received)

    def fresh(self) -> None:
        """Forget what came while nobody followed."""
        self.link.fresh()
        self._forget()

    def _forget(self) -> None:
        self.weight = None
        self._recent.clear()
        self._heard_s = self.link.now_s()
        self._awaited = 0

    @property
    def is_stable(self) -> bool:
        """Marked so by the device, and no fault speaks against it."""
        if self.weight is None or self.faults & faults.SPOILING:
            return False
        return bool(self.weight.weight_flags & WeightFlag.STABLE)

    @property
    def spread_mg(self) -> int:
        """By how much the weight went up and down within the last second."""
        net_mg = [net for _us, net in self._recent]
        return max(net_mg) - min(net_mg) if net_mg else 0

    @property
    def silent_s(self) -> float:
        """For how long no WEIGHT has come."""
        return self.link.now_s() - self._heard_s

    def wait_stable(self, wait_s: float, show: Show = lambda _balance: None) -> Weight:
        """The first stable weight from now on. Raises CommandRefused: how much it moves, or which
        fault holds; NoAnswer if nothing comes. `show` is called some ten times a second.
        """
        end_s = self.link.now_s() + wait_s
        while True:
            self.follow()
            show(self)
            if self.is_stable:
                return self.weight
            if self.link.now_s() >= end_s:
                raise self.why_not_stable(wait_s)

    def why_not_stable(self, wait_s: float) -> CommandRefused | NoAnswer:
        """What keeps the weight from being stable, in words."""
        spoilt = faults.explained(self.faults & faults.SPOILING)
        if spoilt:
            name, words, remedy = spoilt[0]
            return CommandRefused(
                f"no weight to be trusted: {name}, {words}",
                remedy=remedy,
                result=Result.NOT_STABLE,
            )
        if self.weight is None or self.silent_s > SILENCE_S:
            return NoAnswer(
                f"{self.link.name} sends no weight",
                remedy="`terazi info` shows what the converter does.",
            )
        flags = self.weight.weight_flags
        if flags & (WeightFlag.OVER | WeightFlag.UNDER):
            beyond = "more than Max + 9 e" if flags & WeightFlag.OVER else "far below zero"
            return CommandRefused(
                f"the load is {beyond}",
                remedy="Take it off; if the scale is wrong, `terazi calibrate` sets it right.",
                result=Result.NOT_STABLE,
            )
        return CommandRefused(
            f"not stable after {wait_s:g} s: the load moves by {show_mass(self.spread_mg)}",
            remedy="Keep wind and vibration off, or give it longer with --wait.",
            result=Result.NOT_STABLE,
        )

    def obey(self, command, wait_s: float = 0.0, *, show: Show = lambda _balance: None) -> None:
        """A command that may want a stable load, or the EEPROM to be ready: waits for both.

        Raises CommandRefused, and says then by how much the load moves.
        """
        end_s = self.link.now_s() + wait_s
        busy_end_s = self.link.now_s() + SAVED_S
        while True:
            try:
                self.link.command(command)
                return
            except CommandRefused as refused:
                now_s = self.link.now_s()
                if refused.result == Result.BUSY and now_s < busy_end_s:
                    self.follow()
                    continue
                if refused.result not in (Result.NOT_STABLE, Result.WRONG_STATE):
                    raise
                if now_s >= end_s:
                    raise self.why_not_stable(wait_s) from refused
                self.follow()
                show(self)

    def tare(self, wait_s: float, show: Show = lambda _balance: None) -> Weight:
        """Take what lies there off; gives the weight thereafter."""
        return self._weight_after(Tare(), wait_s, show)

    def zero(self, wait_s: float, show: Show = lambda _balance: None) -> Weight:
        """Take what lies there as zero; gives the weight thereafter."""
        return self._weight_after(Zero(), wait_s, show)

    def clear(self) -> Weight:
        """No tare; gives the weight thereafter."""
        return self._weight_after(TareClear(), 0.0)

    def _weight_after(self, command, wait_s: float, show: Show = lambda _balance: None) -> Weight:
        if wait_s > 0:
            self.wait_stable(wait_s, show)
        self._awaited = command.ID
        self.obey(command, wait_s, show=show)
        self.follow(2 * TURN_S)  # a command shows with the next sample: 0.1 s at 10 SPS
        while (self._awaited or self.weight is None) and self.silent_s < SILENCE_S:
            self.follow()
        if self._awaited or self.weight is None:
            raise self.why_not_stable(wait_s)
        return self.weight

    def points(self) -> list[Point]:
        """The calibration's points; in the middle of a calibration, those taken so far."""
        points: list[Point] = []
        for index in range(POINTS_MAX):
            try:
                points.append(self.link.ask(GetPoint(index), Point, index=index))
            except CommandRefused as refused:
                if refused.result != Result.NOTHING_THERE:
                    raise
                break
        return points

    def wait_saved(self) -> int:
        """Wait until the settings are in the EEPROM; gives the record's number.

        Raises CannotWrite if they do not arrive there.
        """
        end_s = self.link.now_s() + SAVED_S
        while (status := self.link.status()).settings_state == SettingsState.WRITING:
            if self.link.now_s() > end_s:
                break
            self.follow()
        if status.settings_state != SettingsState.IDLE:
            raise CannotWrite(
                f"{self.link.name} could not write its settings: what it wrote did not read back",
                remedy="They hold until the next reset. Try again; an EEPROM that stays so is worn "
                "out.",
            )
        return status.settings_saved
