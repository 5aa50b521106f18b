# SPDX-License-Identifier: MIT
"""The test double in lock step: a transport whose time goes by only while it is read, and a
terminal whose person follows a script. Nothing here waits, and every run is the same.
"""

import random
from collections.abc import Callable

from host.tests.fake_chain import COUNTS_PER_G, EMPTY_COUNTS, RATE_HZ, Chain
from host.tests.fake_commands import Eeprom
from host.tests.fake_imu import FakeImu
from terazi.cshared import FrameDecoder
from terazi.link import Link
from terazi.link.generated.messages import MESSAGES_BY_ID
from terazi.units import US_PER_S


class Bench:
    """A board with a pan: put `load_g` on it, and talk through `link`.

    moves_g : amplitude of a swing that keeps the load from standing still.
    warm : degC at a time since the bench was made; None: it has no thermometer.
    drift : counts that the cell drifts by at a temperature, with load_g on it.
    lose : asked for each command's class name; True: obeyed, but the answer never arrives.
    deaf : likewise; True: the command never arrives.
    imu : makes its IMU at each reset.
    """

    def __init__(
        self,
        *,
        eeprom: Eeprom | None = None,
        noise_counts: float = 40.0,
        counts_per_g: float = COUNTS_PER_G,
        cell: Callable[[float], float] = lambda load_g: load_g,
        warm: Callable[[float], float] | None = None,
        drift: Callable[[float, float], float] = lambda _degrees, _load_g: 0.0,
        lose: Callable[[str], bool] = lambda _name: False,
        deaf: Callable[[str], bool] = lambda _name: False,
        imu: Callable[[], FakeImu] | None = None,
        seed: int = 7,
    ) -> None:
        self.imu = imu
        self.load_g = 0.0
        self.moves_g = 0.0
        self.counts_per_g, self.cell = counts_per_g, cell
        self.warm, self.drift = warm, drift
        self.lose, self.deaf = lose, deaf
        self.commands: list[str] = []
        self._noise = random.Random(seed)
        self._noise_counts = noise_counts
        self._decoder = FrameDecoder()
        self._waiting = b""
        self._now_s = 0.0
        self.eeprom = eeprom or Eeprom()
        self.reset()
        self.link = Link(self, name="the bench")
        self.link.hello()

    def reset(self) -> None:
        """Power off and on: what is not in EEPROM is gone."""
        self.chain = Chain(self._counts, imu=self.imu() if self.imu else None)
        self.chain.start(self.eeprom)
        self._begin_s = self._now_s
        self._waiting = self.chain.frame(self.chain.hello())
        self._statuses = 0

    def _counts(self, t_s: float) -> int:
        load_g = self.cell(self.load_g) + self.moves_g * (1 if int(t_s * 8) % 2 else -1)
        noise = self._noise.gauss(0.0, self._noise_counts)
        if self.warm is not None:
            degrees = self.warm(self._now_s)
            self.chain.temperature_centi = round(degrees * 100)
            noise += self.drift(degrees, load_g)
        return round(EMPTY_COUNTS + self.counts_per_g * load_g + noise)

    # The transport.

    def read(self, timeout_s: float) -> bytes:
        end_s = self._now_s + timeout_s
        while not self._waiting and self._now_s < end_s:
            next_s = self._begin_s + (self.chain.conversion + 1) / RATE_HZ
            self._now_s = min(end_s, next_s)
            if next_s <= end_s:
                self._convert()
        data, self._waiting = self._waiting, b""
        return data

    def write(self, data: bytes) -> None:
        for frame in self._decoder.feed(data):
            name = MESSAGES_BY_ID[frame.id].__name__
            self.commands.append(name)
            if self.deaf(name):
                continue
            answer = self.chain.answer(frame)
            if not self.lose(name):
                self._waiting += answer

    def now_s(self) -> float:
        return self._now_s

    def close(self) -> None:
        pass

    def _convert(self) -> None:
        chain = self.chain
        sample = chain.sample()
        if chain.wants(sample):
            self._waiting += chain.frame(sample)
        for message, device_us in chain.unasked():
            if chain.wants(message):
                self._waiting += chain.frame(message, device_us)
        if chain.device_us // US_PER_S > self._statuses:
            self._statuses += 1
            for message in chain.health():
                if chain.wants(message):
                    self._waiting += chain.frame(message)


class Script:
    """A terazi.calibration.Terminal whose person answers by a list.

    Each answer is text, a choice's key, or a function that does something first (puts a mass on,
    presses ctrl-C) and then gives the text. `said` is all that was told, `asked` all questions.
    """

    def __init__(self, *answers: str | Callable[[], str | None]) -> None:
        self.answers = list(answers)
        self.said: list[str] = []
        self.asked: list[str] = []
        self.lives: list[str] = []
        self.turns = 3  # looks at the live line while a mass is put on

    def tell(self, text: str, *, tone: str = "") -> None:
        self.said.append(text)

    def table(self, headings, rows) -> None:
        self.said += ["  ".join(headings), *("  ".join(row) for row in rows)]

    def ask(self, question: str, default: str = "") -> str:
        return self._answer(question) or default

    def choose(self, question: str, choices: dict[str, str]) -> str:
        answer = self._answer(f"{question} {' | '.join(choices)}")
        assert answer in choices, f"{answer!r} is none of {list(choices)}"
        return answer

    def pause(self, text: str, turn: Callable[[], str]) -> None:
        self._answer(text)
        for _turn in range(self.turns):
            self.live(turn())

    def live(self, text: str) -> None:
        if text:
            self.lives.append(text)

    @property
    def text(self) -> str:
        return "\n".join(self.said)

    def _answer(self, question: str) -> str:
        self.asked.append(question)
        assert self.answers, f"the script has no answer to {question!r}; said: {self.said[-3:]}"
        answer = self.answers.pop(0)
        return (answer() or "") if callable(answer) else answer
