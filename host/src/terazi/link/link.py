# SPDX-License-Identifier: MIT
"""A conversation with one board: wait for HELLO, ask, be answered, take what it sends unasked."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence

from terazi.cshared import encode_frame
from terazi.errors import NoAnswer
from terazi.link.generated.messages import Ack, GetInfo, Hello, Result, SetTextMode, Status
from terazi.link.refusals import refusal
from terazi.link.stream import SEQUENCE_PERIOD, MessageStream, Received
from terazi.link.transport import BAUDS, SerialTransport, Transport

# Opening the port resets the board; optiboot then listens for 1 s, and 1.4 s after opening the
# program runs. Twice that for boards with a slower boot loader.
HELLO_AFTER_RESET_S = 3.0
FRAMES_BEFORE_HELLO = 20  # more than a reset board can have left in the line
# So many bytes without a frame: whoever sends them speaks at another rate, or no frames. They are
# more than the line can hold of a frame that was under way, and 0.2 s of a board that streams.
BYTES_WITHOUT_FRAME = 250
ANSWER_S = 0.5
ATTEMPTS = 3
POLL_S = 0.05  # how finely a wait looks at its deadline


class Link:
    """Messages both ways over a transport.

    on_bytes is called with (host_s, bytes) for all that comes in, before anything is decoded: a
    recorder hangs there. host_s counts from the link's making. bauds: what the board may speak
    where it does not answer at the transport's rate; `hello` finds out.
    """

    def __init__(
        self,
        transport: Transport,
        *,
        on_bytes: Callable[[float, bytes], None] | None = None,
        name: str = "the board",
        bauds: Sequence[int] = (),
    ) -> None:
        self.transport = transport
        self.name = name
        self._bauds = tuple(bauds)
        self._bytes_at_turn = 0  # that had come when the rate was changed last
        self.on_bytes = on_bytes
        self.stream = MessageStream(whose=name)
        self._start_s = transport.now_s()
        self._sequence = 0
        self._first_sent = 0  # sequence of the first attempt at the latest request
        self._waiting: deque[Received] = deque()  # not yet given by poll
        # What came since the last request was begun; in a long recording, its end.
        self._answers: deque[Received] = deque(maxlen=1024)

    def __enter__(self) -> "Link":
        return self

    def __exit__(self, *_exception) -> None:
        self.close()

    def close(self) -> None:
        self.transport.close()

    @property
    def baud(self) -> int | None:
        """Bits a second on the line, once `hello` has found them; None: it is no serial line."""
        return getattr(self.transport, "baud", None)

    def now_s(self) -> float:
        """Seconds since the link was made, on the transport's clock."""
        return self.transport.now_s() - self._start_s

    def poll(self, timeout_s: float) -> list[Received]:
        """What came in: what waits already, else whatever one read of the transport brings."""
        if not self._waiting:
            self._read(timeout_s)
        return self.pending()

    def pending(self) -> list[Received]:
        """What has come in and was not polled yet; reads nothing more."""
        received = list(self._waiting)
        self._waiting.clear()
        return received

    def messages(self, seconds: float | None = None) -> Iterator[Received]:
        """Every message in turn, for so many seconds or for ever."""
        end_s = None if seconds is None else self.now_s() + seconds
        while end_s is None or self.now_s() < end_s:
            yield from self.poll(POLL_S)

    def hello(self, timeout_s: float = HELLO_AFTER_RESET_S) -> Hello:
        """Who is there. Waits for the HELLO that follows a reset; if none comes, asks, at each
        rate in turn that the board may speak.

        Messages that arrive meanwhile stay for `poll`. Raises NoAnswer, or FingerprintMismatch.
        """
        if self.stream.hello is None:
            self._wait(lambda: self.stream.hello or self._has_missed_it(), timeout_s)
        if self.stream.hello is None:
            self._ask_for_hello()
        if self.stream.hello is None:
            raise self._no_answer()
        return self.stream.hello

    def request(self, command, timeout_s: float = ANSWER_S, *, attempts: int = ATTEMPTS) -> Ack:
        """Send a command until it is acknowledged, and give the ACK, whatever its result.

        Every command may be repeated without harm, so that a lost ACK is no trouble. Raises
        NoAnswer after the last attempt.
        """
        sent = set()
        self._answers.clear()
        for attempt in range(attempts):
            sequence = self.send(command)
            sent.add(sequence)
            if attempt == 0:
                self._first_sent = sequence
            ack = self._wait(lambda: self._ack(command.ID, sent), timeout_s)
            if ack is not None:
                return ack
        name = type(command).__name__
        raise NoAnswer(f"{self.name} does not acknowledge {name} after {attempts} attempts")

    def command(
        self, command, timeout_s: float = ANSWER_S, *, done_before: Result | None = None
    ) -> None:
        """Send a command that must succeed. Raises CommandRefused if the board says no.

        done_before: what the board answers where it has obeyed this command already. To the
        repetition of a command whose ACK was lost that answer means success; to the first, not.
        """
        ack = self.request(command, timeout_s)
        if ack.result == Result.OK:
            return
        if ack.result == done_before and ack.command_sequence != self._first_sent:
            return
        raise refusal(self.name, command, ack.result)

    def ask(self, command, kind: type, timeout_s: float = ANSWER_S, **fields):
        """The message of a kind, with these fields, that follows a command's ACK.

        An answer that was lost is asked for anew. Raises CommandRefused or NoAnswer.
        """
        for _attempt in range(ATTEMPTS):
            self.command(command, timeout_s)
            answer = self._wait(lambda: self._answered(kind, fields), timeout_s)
            if answer is not None:
                return answer
        name = type(command).__name__
        raise NoAnswer(f"{self.name} acknowledges {name} but sends no {kind.__name__.upper()}")

    def fresh(self) -> None:
        """Forget what waits to be polled: what comes from now on was sent from now on.

        For callers that let time go by without polling, as while a person thinks.
        """
        self.command(GetInfo())
        self._waiting.clear()

    def status(self, timeout_s: float = ANSWER_S) -> Status:
        """The board's health now."""
        return self.ask(GetInfo(), Status, timeout_s)

    def send(self, command) -> int:
        """Send a command's frame without waiting; gives its sequence number."""
        sequence = self._sequence
        self._sequence = (sequence + 1) % SEQUENCE_PERIOD
        # The leading delimiter ends whatever noise stands in the board's receiver.
        self.transport.write(b"\0" + encode_frame(command.ID, sequence, 0, command.pack()))
        return sequence

    def _read(self, timeout_s: float) -> None:
        data = self.transport.read(timeout_s)
        if not data:
            return
        host_s = self.now_s()
        if self.on_bytes is not None:
            self.on_bytes(host_s, data)
        received = self.stream.feed(data, host_s)
        self._waiting.extend(received)
        self._answers.extend(received)

    def _wait(self, found: Callable, timeout_s: float):
        """Read until `found()` gives something, at most timeout_s; gives that or None."""
        end_s = self.now_s() + timeout_s
        while (result := found()) is None and self.now_s() < end_s:
            self._read(POLL_S)
        return result

    def _ack(self, command_id: int, sent: set[int]) -> Ack | None:
        for received in self._answers:
            ack = received.message
            if isinstance(ack, Ack) and ack.command == command_id and ack.command_sequence in sent:
                return ack
        return None

    def _answered(self, kind: type, fields: dict):
        for received in self._answers:
            message = received.message
            if isinstance(message, kind) and all(
                getattr(message, name) == value for name, value in fields.items()
            ):
                return message
        return None

    def _has_missed_it(self) -> bool | None:
        """Whether so much has come without a HELLO that none will: there was no reset, the HELLO
        came before the port was quite open, or the rate is not the board's."""
        return self.stream.frames > FRAMES_BEFORE_HELLO or self._hears_no_frames()

    def _hears_no_frames(self) -> bool | None:
        came = self.stream.bytes_in - self._bytes_at_turn
        return (not self.stream.frames and came > BYTES_WITHOUT_FRAME) or None

    def _ask_for_hello(self) -> None:
        """For a port whose opening does not reset, for a board left in text mode, and for one that
        speaks at another rate."""
        for _attempt in range(ATTEMPTS):
            for number, baud in enumerate(self._bauds or (None,)):
                if number and self.stream.bytes_in == 0:
                    break  # a boot loader alone is silent, and takes another rate for commands
                self._turn_to(baud)
                self.send(SetTextMode(on=0))
                self.send(GetInfo())
                self._wait(lambda: self.stream.hello or self._hears_no_frames(), ANSWER_S)
                if self.stream.hello is not None:
                    return
                if self.stream.frames:
                    self._bauds = ()  # this one it is
                    break

    def _turn_to(self, baud: int | None) -> None:
        """Speak and listen at this rate, or at the one that there is."""
        if baud is not None and baud != self.transport.baud:
            self.transport.set_baud(baud)
        self._bytes_at_turn = self.stream.bytes_in

    def _no_answer(self) -> NoAnswer:
        remedy = (
            "Put Terazi's firmware on it with `terazi flash`; if it is there, press its reset "
            "button, or name the rate of its line with --baud."
        )
        if self.stream.frames:
            return NoAnswer(f"{self.name} sends frames but no HELLO", remedy=remedy)
        if self.stream.bytes_in:
            count = self.stream.bytes_in
            return NoAnswer(
                f"{self.name} sends no Terazi frames{self._at()} "
                f"({count} bytes came, none of them a frame)",
                remedy=remedy,
            )
        return NoAnswer(f"{self.name} does not answer{self._at()}", remedy=remedy)

    def _at(self) -> str:
        """The rates that were tried."""
        bauds = self._bauds or (self.baud,)
        if bauds == (None,):
            return ""
        *most, last = map(str, bauds)
        return f" at {', '.join(most)} or {last} baud" if most else f" at {last} baud"


def open_link(
    port: str,
    baud: int | None = None,
    *,
    on_bytes: Callable[[float, bytes], None] | None = None,
) -> Link:
    """A link over a serial port; baud None: whichever the board speaks, found by `Link.hello`.

    Raises PortMissing or PortBusy.
    """
    bauds = BAUDS if baud is None else ()
    transport = SerialTransport(port, BAUDS[0] if baud is None else baud)
    return Link(transport, on_bytes=on_bytes, name=port, bauds=bauds)
