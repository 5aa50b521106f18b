# SPDX-License-Identifier: MIT
"""Twin of faults.h in Python's unbounded integers, straight from its contract."""

from __future__ import annotations

from collections import deque
from enum import IntEnum, IntFlag

from terazi.models.exact import COUNTS_MAX, COUNTS_MIN


class Event(IntEnum):
    """faults_event_t."""

    NOTHING = 0
    CONVERSION = 1
    DROPPED = 2
    BAD_FRAME = 3
    TIMED_OUT = 4
    STUCK_LOW = 5
    OFF_BEAT = 6


class Fault(IntFlag):
    """Bits of `held` and `seen`."""

    CABLE_OUT = 1
    DOUT_STUCK = 2
    AT_RAIL = 4
    RATE = 8
    FRAMES_LOST = 16
    NOISE = 32


CHANGED, SPOILT, RESTART = 1, 2, 4
TAPS = (1, -3, 4, -4, 3, -1)  # of the moves: (1 - 1/z)^4 (1 + 1/z^2) / (1 - 1/z)
MOVE_COUNTS, MOVE_LIMIT = 256, 2047
STIR, LEAVE, BACK = 512 // MOVE_COUNTS, 2048 // MOVE_COUNTS, 1024 // MOVE_COUNTS
NOISE_COUNTS, NOISE_LEAST = 4000, 400
STIRRED, LOUD, QUIET, QUIET_PART = 3, 5, 4, 8
REPEATS, GOOD = 5, 3
NAMED = {
    Event.BAD_FRAME: Fault.FRAMES_LOST,
    Event.TIMED_OUT: Fault.CABLE_OUT,
    Event.STUCK_LOW: Fault.DOUT_STUCK,
}


class Faults:
    """faults.h."""

    def __init__(self) -> None:
        self.held = self.seen = Fault(0)
        self.run: list[int] = []  # counts that may be compared with one another
        self.moves = deque([0] * len(TAPS), maxlen=len(TAPS))  # of the run, the newest first
        self.noisy = self.good = 0
        self.off = False
        self.limit_noise(NOISE_COUNTS)

    def limit_noise(self, noise_counts: int) -> None:
        """What the filter leaves may be 14 times as much, in MOVE_COUNTS."""
        self.noise_limit = max(noise_counts, NOISE_LEAST) // 16 * 14 // 16

    def pause(self) -> None:
        """A gap on purpose."""
        self.run, self.off = [], False

    def update(self, event: int, counts: int = 0) -> int:
        """Take one event; gives CHANGED, SPOILT and RESTART as bits."""
        before = self.held
        if event != Event.NOTHING:
            found = self._judge(Event(event), counts)
            is_good = event == Event.CONVERSION and not found
            self.good = min(self.good + 1, GOOD) if is_good else 0
            if self.good == GOOD:
                self.held &= Fault.NOISE
            self.held |= found
            self.seen |= self.held
        changed = CHANGED if self.held != before else 0
        if self.held:
            return changed | SPOILT
        return changed | (RESTART if before else 0)

    def _judge(self, event: Event, counts: int) -> Fault:
        if event == Event.CONVERSION:
            self.off = False
            return self._conversion(counts)
        was_off, was_in_run = self.off, bool(self.run)
        self.pause()
        if event == Event.OFF_BEAT:
            self.off = True
            return Fault.RATE if was_off else Fault.FRAMES_LOST
        if event == Event.DROPPED:
            return Fault.FRAMES_LOST if was_in_run else Fault(0)
        return NAMED[event]

    def _conversion(self, counts: int) -> Fault:
        if counts in (COUNTS_MIN, COUNTS_MAX):
            self.run = []
            return Fault.AT_RAIL
        self.run = [*self.run[-REPEATS:], counts]
        if len(self.run) == 1:
            self.moves.extend([0] * len(TAPS))
            return Fault(0)
        move = (counts - self.run[-2]) // MOVE_COUNTS
        self.moves.appendleft(min(max(move, -MOVE_LIMIT), MOVE_LIMIT))
        self._listen()
        is_frozen = len(self.run) > REPEATS and len(set(self.run)) == 1
        return Fault.DOUT_STUCK if is_frozen else Fault(0)

    def _listen(self) -> None:
        rest = sum(tap * move for tap, move in zip(TAPS, self.moves, strict=True))
        stirred = sum(abs(move) >= STIR for move in self.moves)
        loud = abs(rest) >= self.noise_limit and stirred >= STIRRED
        if self.held & Fault.NOISE:
            quiet = abs(rest) < self.noise_limit // QUIET_PART
            self.noisy = self.noisy - 1 if quiet else QUIET
        else:
            self.noisy = max(self.noisy + (1 if loud else -1), 0)
        if self.noisy == LOUD or self._is_spike():
            self.noisy, self.held = QUIET, self.held | Fault.NOISE
        if self.noisy == 0:
            self.held &= ~Fault.NOISE

    def _is_spike(self) -> bool:
        """Left n conversions ago, after two small moves, and back with this one."""
        moves = list(self.moves)
        return any(
            abs(moves[n]) >= LEAVE
            and abs(sum(moves[: n + 1])) < BACK
            and all(abs(move) < STIR for move in moves[n + 1 : n + 3])
            for n in (1, 2)
        )
