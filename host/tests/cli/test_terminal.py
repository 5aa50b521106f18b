# SPDX-License-Identifier: MIT
"""The dialogues' terminal, on a pseudo-terminal of 80 x 24, by a person's keys."""

import os
import pty
import re
import select
import signal
import subprocess
import sys
import time

from host.tests.cli.test_scale_cli import calibrating, constant
from host.tests.fake_device import FakeDevice

TIMEOUT_S = 60


class Person:
    """Runs a command on a terminal, waits for what it shows, and types."""

    def __init__(self, *words):
        self._master, slave = pty.openpty()
        self.shown = ""
        self.running = subprocess.Popen(
            [sys.executable, "-m", "terazi", *map(str, words)],
            stdin=slave,
            stdout=slave,
            stderr=slave,
            start_new_session=True,
            env=os.environ | {"TERM": "xterm-256color", "COLUMNS": "80", "LINES": "24"},
        )
        os.close(slave)

    def sees(self, pattern):
        """Wait for a pattern in what is shown after what was seen before."""
        end_s = time.monotonic() + TIMEOUT_S
        while not (found := re.search(pattern, plain(self.shown))):
            assert time.monotonic() < end_s, f"{pattern!r} never came: {plain(self.shown)[-800:]}"
            if select.select([self._master], [], [], 0.2)[0]:
                try:
                    self.shown += os.read(self._master, 4096).decode()
                except OSError:  # it has ended
                    assert re.search(pattern, plain(self.shown)), plain(self.shown)[-800:]
        self.shown = plain(self.shown)[found.end() :]
        return found

    def types(self, text):
        os.write(self._master, text.encode())

    def ends(self):
        """Its exit code; what it shows last is kept."""
        end_s = time.monotonic() + TIMEOUT_S
        while self.running.poll() is None and time.monotonic() < end_s:
            self._read()
        self._read()
        assert self.running.poll() is not None, f"it does not end: {plain(self.shown)[-800:]}"
        return self.running.returncode

    def _read(self):
        try:
            if select.select([self._master], [], [], 0.1)[0]:
                self.shown += os.read(self._master, 4096).decode()
        except OSError:
            pass

    def __enter__(self):
        return self

    def __exit__(self, *_exception):
        self.running.kill()
        self.running.wait()
        os.close(self._master)


def plain(text):
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text)


def test_a_person_calibrates_by_keys_and_sees_the_weight_live():
    with calibrating(0, 5000) as device, Person("calibrate", device.path) as person:
        for question in (r"Max, the greatest load\? \[5000g\]", r"e, .* counts\? \[1g\]", r"\[2\]"):
            person.sees(question)
            person.types("\n")
        person.sees("Take everything off, then press Enter")
        person.sees(r"0\.\d\d g  stable")
        person.types("\n")
        person.sees(r"Taken: 0\.0 g at")
        person.sees(r"\[5000g\]")
        person.types("\n")
        person.sees("Put 5 000.0 g on, then press Enter")
        person.types("\n")
        person.sees(r"Taken: 5 000\.0 g at")
        person.sees(r"1  save: weigh by these points")
        person.types("sa\n")
        person.sees("Calibrated: 2 points, Max 5 000.0 g, e 1.0 g; saved, and read back")
        person.sees("Its mass, or Enter to end")
        person.types("\n")
        assert person.ends() == 0
        assert [point.mass_mg for point in device.chain.points] == [0, 5_000_000]


def test_ctrl_c_in_the_middle_leaves_the_board_as_it_was():
    with calibrating(0, 5000) as device, Person("calibrate", device.path) as person:
        for question in (r"greatest load\?", r"counts\?", r"\[2\]"):
            person.sees(question)
            person.types("\n")
        person.sees(r"g  stable")
        before = list(device.chain.points)
        person.running.send_signal(signal.SIGINT)
        assert person.ends() == 130
        assert "interrupted" in plain(person.shown)
        assert "Traceback" not in person.shown
        assert device.chain.staged is None
        assert device.chain.points == before


def test_watch_obeys_keys_and_says_what_came_of_them():
    with FakeDevice(load=constant(300.0), speed=5.0) as device:
        with Person("watch", device.path) as person:
            person.sees(r"300 g  stable")
            person.types("t")
            person.sees(r"0 g  stable   net, tare (300|299)\.\d\d g")
            person.types("c")
            person.sees(r"300 g  stable")
            person.types("q")
            assert person.ends() == 0
        assert device.chain.scale.tare_mg == 0


def test_watch_shows_why_a_key_was_refused():
    board = FakeDevice(load=constant(4000.0), speed=5.0)
    with board as device, Person("watch", device.path) as person:
        person.sees(r"4000 g  stable")
        person.types("z")
        person.sees(r"zero: .* refuses Zero: the load is further than 2 % of Max")
        person.types("q")
        assert person.ends() == 0
