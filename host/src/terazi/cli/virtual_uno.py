# SPDX-License-Identifier: MIT
"""The simulated Uno as a program beside this one, where it is installed.

Its licence is another one, so that nothing of it is imported: it is started as a user would.
"""

import importlib.util
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from terazi.errors import TeraziError

MODULE = "virtual_uno"
IMAGE = Path(".build") / "firmware" / "terazi.elf"  # below the checkout that the module lies in
START_TIMEOUT_S = 20.0
STOP_TIMEOUT_S = 5.0


def find_image() -> Path | None:
    """The built firmware beside the simulator; None where one of them is missing."""
    found = importlib.util.find_spec(MODULE)
    if found is None or found.origin is None:
        return None
    for folder in Path(found.origin).resolve().parents:
        if (folder / IMAGE).is_file():
            return folder / IMAGE
    return None


@contextmanager
def virtual_uno(image: Path, *options: object) -> Iterator[str]:
    """Run it while the block lasts; gives its port. Raises TeraziError if it does not start."""
    with tempfile.TemporaryDirectory(prefix="terazi-") as folder:
        port, log = Path(folder) / "uno", Path(folder) / "log"
        command = [sys.executable, "-m", MODULE, "--elf", image, "--link", port, *options]
        with log.open("w", encoding="utf-8") as output:
            board = subprocess.Popen(
                [str(word) for word in command], stdout=output, stderr=subprocess.STDOUT
            )
        try:
            deadline_s = time.monotonic() + START_TIMEOUT_S
            while not port.exists():
                if board.poll() is not None or time.monotonic() > deadline_s:
                    said = log.read_text(encoding="utf-8").strip()
                    raise TeraziError(f"the simulated Uno did not start: {said}")
                time.sleep(0.02)
            yield str(port)
        finally:
            if board.poll() is None:
                board.terminate()
            try:
                board.wait(STOP_TIMEOUT_S)
            except subprocess.TimeoutExpired:
                board.kill()
                board.wait()
