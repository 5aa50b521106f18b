# SPDX-License-Identifier: MIT
"""An avrdude that does as it is told."""

import sys

import pytest

# -P's argument is the port; program is what it does.
PLAYER = """#!{python}
import os, sys, time
port = sys.argv[sys.argv.index("-P") + 1]
def say(text):
    sys.stderr.write(text)
    sys.stderr.flush()
{program}
"""


@pytest.fixture
def play(tmp_path, monkeypatch):
    """play(program): an avrdude that does this, and nothing else on PATH."""
    folder = tmp_path / "bin"
    folder.mkdir()

    def play(program: str) -> None:
        script = folder / "avrdude"
        script.write_text(PLAYER.format(python=sys.executable, program=program))
        script.chmod(0o755)
        monkeypatch.setenv("PATH", str(folder))

    return play
