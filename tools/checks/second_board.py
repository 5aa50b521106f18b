# SPDX-License-Identifier: MIT
"""The cases again, through a serial port, on a second virtual board that stands for a real one.

python -m tools.checks.second_board [PYTEST ARGUMENTS]
"""

import subprocess
import sys
from pathlib import Path

from tools.virtual_board import BoardFailed, virtual_board

ROOT = Path(__file__).resolve().parents[2]
IMAGE = ROOT / ".build/firmware/terazi.elf"
PORT = ROOT / ".build/second_uno"
LOG = ROOT / ".build/log/second_uno.log"


def main(arguments: list[str]) -> int:
    try:
        with virtual_board(IMAGE, PORT, LOG, "--noise", 39, "--scenario", 100):
            cases = ["-m", "pytest", "hil_tests/cases", f"--uno={PORT}", *arguments]
            return subprocess.run([sys.executable, *cases], cwd=ROOT, check=False).returncode
    except BoardFailed as failure:
        print(failure, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
