# SPDX-License-Identifier: MIT
"""What a person sees while recording: the live line, on a terminal."""

import os
import pty
import re
import signal
import subprocess
import sys

import pytest

from host.tests.fake_device import FakeDevice

TIMEOUT_S = 60


def seen(device, capture, until, *words):
    """Run `terazi log` on a pseudo-terminal until the pattern appears; gives all that was shown."""
    master, slave = pty.openpty()
    running = subprocess.Popen(
        [sys.executable, "-m", "terazi", "log", device.path, "-o", str(capture), *words],
        stdout=subprocess.DEVNULL,
        stderr=slave,
        env=os.environ | {"TERM": "xterm-256color", "COLUMNS": "120"},
    )
    os.close(slave)
    shown = ""
    try:
        while not re.search(until, plain(shown)):
            shown += os.read(master, 4096).decode()
        running.send_signal(signal.SIGINT)
        running.wait(TIMEOUT_S)
    finally:
        running.kill()
        running.wait()
        os.close(master)
    assert running.returncode == 0
    return plain(shown)


def plain(text):
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text)


@pytest.fixture
def capture(tmp_path):
    return tmp_path / "one.terazi"


def test_live_line_shows_rate_weight_and_that_nothing_is_lost(capture):
    with FakeDevice() as device:
        shown = seen(
            device, capture, r"82\.00 SPS +(499|500)\.\d\d g +stable +0 frames lost +\d+ samples"
        )
    assert "recording to" in shown
    assert "ctrl-C ends the recording" in shown


def test_live_line_shows_lost_frames(capture):
    with FakeDevice(lose=frozenset({30, 31, 32})) as device:
        seen(device, capture, r"3 frames lost", "--seconds", "600")


def test_live_line_says_why_no_samples_come(capture, monkeypatch):
    with FakeDevice(silent_after=40, speed=5.0) as device:
        seen(device, capture, r"no samples for \d+ s \(converter timed out\)")


def test_live_line_says_when_the_converter_stands_at_its_rail(capture):
    with FakeDevice(load=lambda _t_s: (1 << 23) - 1) as device:
        seen(device, capture, r"at the converter's rail")
