# SPDX-License-Identifier: MIT
"""A virtual Uno on a serial port, as a program of its own, for as long as a block lasts."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

START_TIMEOUT_S = 20.0
STOP_TIMEOUT_S = 5.0


class BoardFailed(Exception):
    """The simulator did not start, or did not last; says what it said."""


@contextmanager
def virtual_board(elf: Path, link: Path, log: Path, *options: object) -> Iterator[None]:
    """Run ``python -m virtual_uno`` with its port at ``link``; its words go to ``log``."""
    command = [sys.executable, "-m", "virtual_uno", "--elf", elf, "--link", link, *options]
    link.unlink(missing_ok=True)
    with log.open("w", encoding="utf-8") as output:
        board = subprocess.Popen(
            [str(word) for word in command], stdout=output, stderr=subprocess.STDOUT
        )
    try:
        deadline_s = time.monotonic() + START_TIMEOUT_S
        while not link.exists():
            if board.poll() is not None or time.monotonic() > deadline_s:
                raise BoardFailed(f"the virtual Uno did not start: {log.read_text().strip()}")
            time.sleep(0.02)
        yield
        if board.poll() not in (None, 0):
            raise BoardFailed(f"the virtual Uno ended early: {log.read_text().strip()}")
    finally:
        if board.poll() is None:
            board.send_signal(signal.SIGINT)
        try:
            board.wait(STOP_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            board.kill()
            board.wait()
