# SPDX-License-Identifier: MIT
"""What a board on a serial port cannot do must skip by name, and the rest must run.

A second simulated Uno, in a process of its own, stands for a real one. All cases run on such a
board in a stage of `./dev test`; here a few of each kind, and their reasons are looked at.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from boards import IMAGE
from tools.virtual_board import virtual_board

HERE = Path(__file__).resolve().parent
CHOSEN = (
    "names_the_chain or reset_cause or get_info or every_ack or makes_it_weigh or rate_82 "
    "or settling_conversions or silence or loose_contact"
)


@pytest.fixture
def port(tmp_path, monkeypatch):
    paths = (HERE, HERE.parent / ".build" / "bench", HERE.parent)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(map(str, paths)))
    link = tmp_path / "uno"
    with virtual_board(IMAGE, link, tmp_path / "uno.log", "--noise", 38.7):
        yield link


def test_a_board_on_a_port_runs_what_it_can_and_skips_the_rest_by_name(port):
    options = ["-q", "-rs", "-p", "no:cacheprovider", "-k", CHOSEN, f"--uno={port}"]
    run = subprocess.run(
        [sys.executable, "-m", "pytest", *options, str(HERE / "cases")],
        capture_output=True,
        text=True,
        timeout=120,
        cwd=HERE.parent,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert int(re.search(r"(\d+) passed", run.stdout)[1]) == 4
    for reason in (
        "a real board cannot place a load by itself",
        "a real board cannot break its own wires",
        "a real board cannot tell which conversions settled",
        "a real board cannot be reset by power_on from its serial port",
        "a real board's converter is as it is: rate_sps",
    ):
        assert reason in run.stdout
