# SPDX-License-Identifier: MIT
"""What a scale's own display would show, and everything that it tells, in words."""

from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass, field

from terazi.control import faults
from terazi.control.balance import Balance
from terazi.control.quantities import show_mass
from terazi.link import Link, Received
from terazi.link.generated.messages import (
    Attitude,
    Fault,
    FaultFlag,
    ImuStatus,
    Product,
    Status,
    Step,
    Unit,
    Weight,
    WeightFlag,
)
from terazi.units import hz_from_q16, s_from_us

UNWEIGHED = 255  # product.verdict
EVENTS_KEPT = 6
TEMPERATURE_UNKNOWN = -(1 << 31)
BLANK = "-----"


def shown(weight: Weight) -> str:
    """The display: 499.8 g, or dashes where nothing is to be shown."""
    unit = weight.unit.name.lower() if isinstance(weight.unit, Unit) else "?"
    unit = "N" if unit == "n" else unit
    untold = weight.weight_flags & (WeightFlag.OVER | WeightFlag.UNDER)
    if untold or weight.faults & faults.SPOILING:
        return f"{BLANK} {unit}"
    return f"{weight.shown / 10**weight.decimals:.{weight.decimals}f} {unit}"


def marks(weight: Weight) -> list[str]:
    """What stands beside the number on a scale's display."""
    flags = weight.weight_flags
    words = ["stable" if flags & WeightFlag.STABLE else "moving"]
    if flags & WeightFlag.AT_ZERO:
        words.append("zero")
    if flags & WeightFlag.TARED:
        words.append(f"net, tare {show_mass(weight.tare_mg)}")
    if flags & WeightFlag.OVER:
        words.append("over")
    if flags & WeightFlag.UNDER:
        words.append("under")
    if flags & WeightFlag.FROZEN:
        words.append("held")
    if weight.calibrating:
        words.append(f"calibrating, {weight.calibrating - 1} points")
    if weight.pieces:
        words.append(f"{weight.pieces} pieces")
    return words


@dataclass
class Counts:
    """What the checkweigher has counted since it was seen."""

    weighed: int = 0
    unweighed: int = 0
    per_minute: float = 0.0
    last: Product | None = None
    classes: Counter = field(default_factory=Counter)  # of those seen here, by class

    def take(self, product: Product) -> None:
        self.last = product
        self.weighed, self.unweighed = product.weighed, product.unweighed
        self.per_minute = product.per_minute_q8 / 256
        if product.verdict != UNWEIGHED:
            self.classes[product.verdict] += 1


class Watch:
    """Everything that a scale tells, as `balance` is followed.

    on_told is called with each message and the events in it, each a line of words.
    """

    def __init__(self, link: Link) -> None:
        self.balance = Balance(link)
        self.balance.on_received = self._note
        self.on_told: Callable[[Received, list[str]], None] = lambda _received, _events: None
        self.status: Status | None = None
        self.attitude: Attitude | None = None
        self.imu_status: ImuStatus | None = None
        self.counts = Counts()
        self.events: deque[str] = deque(maxlen=EVENTS_KEPT)
        self.restarts = 0
        self._faults = FaultFlag(0)

    def _note(self, received: Received) -> None:
        """Note a message, and tell it with the events in it, each a line of words."""
        message = received.message
        lines = []
        if received.boot != self.restarts:
            self.restarts = received.boot
            self.attitude = self.imu_status = None
            lines.append("the board has started anew")
        if isinstance(message, Status):
            self.status = message
        if isinstance(message, Attitude):
            self.attitude = message
        if isinstance(message, ImuStatus):
            self.imu_status = message
        if isinstance(message, (Weight, Status, Fault)):
            lines += self._changes_of_faults(message.faults)
        if isinstance(message, Step):
            lines.append(f"step {message.steps}: {_from_to(message)}")
        if isinstance(message, Product):
            self.counts.take(message)
            lines.append(product_words(message))
        stamped = [f"{s_from_us(received.device_us):10.3f} s  {line}" for line in lines]
        self.events.extend(stamped)
        self.on_told(received, stamped)

    @property
    def faults(self) -> FaultFlag:
        return self._faults

    @property
    def rate_hz(self) -> float:
        """As the device measured it; 0 until it is known."""
        return hz_from_q16(self.status.converter_rate_hz_q16) if self.status else 0.0

    def _changes_of_faults(self, now: FaultFlag) -> list[str]:
        come, gone = now & ~self._faults, self._faults & ~now
        self._faults = now
        lines = [f"fault: {name}: {words}" for name, words, _remedy in faults.explained(come)]
        return lines + [f"over: {name}" for name in faults.names(gone)]


def temperature_deg_c(weight: Weight) -> float | None:
    """Of the device's thermometer; None where it knows none."""
    if weight.temperature_centi == TEMPERATURE_UNKNOWN:
        return None
    return weight.temperature_centi / 100


def product_words(product: Product) -> str:
    """A product that has passed, in words."""
    if product.verdict == UNWEIGHED:
        return f"product {product.weighed + product.unweighed}: not weighed"
    number = product.weighed + product.unweighed
    return f"product {number}: {show_mass(product.mass_mg)}, class {product.verdict}"


def _from_to(step: Step) -> str:
    return f"{show_mass(step.from_mg)} to {show_mass(step.to_mg)}"
