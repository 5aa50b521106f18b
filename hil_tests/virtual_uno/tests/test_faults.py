# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults by the clock and by word, as a person asks for them."""

import itertools
import subprocess
import sys

import pytest

from virtual_uno import Uno
from virtual_uno.faults import FaultClock, FaultError, Misbehaviour, Timed
from virtual_uno.hx711 import FAULTS


@pytest.fixture
def board():
    return Uno()


def run(board, clock, seconds):
    for _ in range(round(seconds / 0.002)):
        board.run(0.002)
        clock.look()


def silent_spans(board):
    """(from, to) of gaps between conversions of more than two periods."""
    at_s = board.conversions["time_s"]
    return [(a, b) for a, b in itertools.pairwise(at_s) if b - a > 2.5 / 80]


def test_a_fault_begins_and_ends_by_the_clock(board):
    run(board, FaultClock(board, [Timed.parse("cable_out@0.5..0.9")]), 1.5)
    ((begin, end),) = silent_spans(board)
    assert begin == pytest.approx(0.5, abs=0.015)
    assert end == pytest.approx(0.9 + 1 / 80, abs=0.005)


@pytest.mark.parametrize("name", ["imu_unplugged", "sda_stuck", "scl_stuck", "deaf"])
def test_a_fault_of_the_bus_begins_and_ends_by_the_clock(name):
    board, seen = FakeBus(), []
    clock = FaultClock(board, [Timed.parse(f"{name}@0.3..0.6"), Timed.parse("deaf@0.7..0.8")])
    for board.seconds_since_reset in (0.1, 0.3, 0.5, 0.6, 0.75, 0.9):
        clock.look()
        seen.append(set(board.held))
    assert seen == [set(), {name}, {name}, set(), {"deaf"}, set()]


class FakeBus:
    """A board that notes what its bus is told."""

    def __init__(self):
        self._board = Uno()
        self.core = self._board.core
        self.bus = self.imu = self
        self.held = set()

    def fault(self, name):
        self.held.add(name)

    def clear_faults(self):
        self.held -= {"sda_stuck", "scl_stuck", "deaf"}

    def unplug(self):
        self.held.add("imu_unplugged")

    def plug(self):
        self.held.discard("imu_unplugged")


def test_faults_overlap_without_ending_one_another(board):
    timed = [Timed.parse("cable_out@0.3..0.9"), Timed.parse("rail,side=low@0.5..0.7")]
    run(board, FaultClock(board, timed), 1.2)
    assert len(silent_spans(board)) == 1
    assert board.conversions["counts"].min() > -8_388_608


def test_what_comes_once_comes_once_and_again_after_a_reset(board):
    clock = FaultClock(board, [Timed.parse("glitch@0.2")])
    run(board, clock, 1.0)
    assert board.conversions["settling"].sum() == 8
    board.reset()
    clock.restart()
    run(board, clock, 0.5)
    assert board.conversions["settling"].sum() == 12


def test_a_fault_without_an_end_stays(board):
    run(board, FaultClock(board, [Timed.parse("rail@0.2")]), 1.0)
    assert board.conversions["counts"][-20:].tolist() == [8_388_607] * 20


def test_words_begin_faults_and_clear_ends_them(board):
    clock = FaultClock(board, [])
    clock.say("rail,side=low\n")
    run(board, clock, 0.5)
    assert board.conversions["counts"][-1] == -8_388_608
    clock.say("clear")
    run(board, clock, 0.1)
    assert board.conversions["counts"][-1] == 0
    clock.say("glitch")
    clock.say("")
    run(board, clock, 0.1)
    assert board.conversions["settling"].sum() == 8


@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_can_be_asked_for(board, name):
    run(board, FaultClock(board, [Timed.parse(f"{name}@0.1..0.2")]), 0.4)
    assert board.conversion_count > 6


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("gremlin@1", "no fault 'gremlin'"),
        ("cable_out", "NAME"),
        ("cable_out@x", "NAME"),
        ("cable_out@3..2", "NAME"),
        ("cable_out@-1", "NAME"),
        ("rail,side=left@1", "left"),
        ("rail,colour=red@1", "side"),
        ("noise,counts=many@1", "no number"),
        ("rate,factor=0@1", "positive"),
        ("cable_out,length=3@1", "none"),
    ],
)
def test_what_cannot_be_understood_is_refused_by_name(words, said):
    with pytest.raises(FaultError, match=said):
        Timed.parse(words)


def test_a_misbehaviour_keeps_its_details():
    assert Misbehaviour.parse("bit_lost, bit=3,frames=2").how == {"bit": 3, "frames": 2}


def program(*arguments, typed=""):
    return subprocess.run(
        [sys.executable, "-m", "virtual_uno", *arguments],
        input=typed,
        capture_output=True,
        text=True,
        timeout=120,
    )


def test_the_program_misbehaves_when_it_is_told(avr, tmp_path):
    truth = tmp_path / "truth.csv"
    common = ["--elf", str(avr("reader.c")), "--speed", "0", "--seconds", "1"]
    done = program(*common, "--truth", str(truth), "--fault", "rail@0.5..0.6")
    assert done.returncode == 0, done.stderr
    at_rail = [row for row in truth.read_text().splitlines() if row.endswith(",8388607")]
    assert 7 <= len(at_rail) <= 9
    done = program(*common, "--truth", str(truth), "--faults-by-word", typed="nonsense\nrail\n")
    assert "nonsense" in done.stderr
    assert truth.read_text().count(",8388607") > 70


def test_the_program_refuses_a_fault_that_there_is_not(avr):
    done = program("--elf", str(avr("reader.c")), "--fault", "gremlin@1", "--seconds", "1")
    assert done.returncode == 2
    assert "gremlin" in done.stderr
