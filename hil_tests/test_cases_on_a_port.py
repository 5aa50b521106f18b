# SPDX-License-Identifier: MIT
"""The same cases against a board on a serial port: a second simulated Uno stands for a real one.

Here time is real and the port is all there is. What such a board cannot do must skip by name.
"""

import os
import re
import subprocess
import sys

import pytest

from boards import IMAGE

HERE = os.path.dirname(os.path.abspath(__file__))
# Quick ones, and one at least of every kind that a real board must refuse.
CHOSEN = (
    "hello or get_info or bit_identical or torn_frame or settling or silence or entered_and_left "
    "or takes_the_present or rate_82 or before_the_first or makes_it_weigh_nothing"
)


@pytest.fixture
def port():
    """The pseudo-terminal of a simulated Uno that runs in real time in a process of its own."""
    command = [sys.executable, "-m", "virtual_uno", "--elf", str(IMAGE), "--noise", "38.7"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment()) as board:
        yield board.stdout.readline().strip()
        board.terminate()


def environment():
    root = os.path.dirname(HERE)
    paths = [HERE, os.path.join(root, ".build", "bench"), root]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}


def test_the_cases_pass_on_a_port_and_skip_by_name_what_a_port_cannot_do(port):
    assert os.path.exists(port), "the board did not say where its port is"
    options = ["-q", "-rs", "-p", "no:cacheprovider", "-k", CHOSEN, f"--uno={port}"]
    run = subprocess.run(
        [sys.executable, "-m", "pytest", *options, os.path.join(HERE, "cases")],
        capture_output=True,
        text=True,
        timeout=240,
        env=environment(),
        cwd=os.path.dirname(HERE),
    )
    assert run.returncode == 0, run.stdout + run.stderr
    passed, skipped = (
        int(re.search(rf"(\d+) {word}", run.stdout)[1]) for word in ("passed", "skipped")
    )
    assert passed >= 10
    assert skipped >= 8
    for reason in (
        "a real board cannot place a load by itself",
        "a real board cannot break its own wires",
        "a real board cannot tell which conversions settled",
        "a real board cannot be reset by power_on from its serial port",
        "a real board's converter is as it is: rate_sps",
    ):
        assert reason in run.stdout
