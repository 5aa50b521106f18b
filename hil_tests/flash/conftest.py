# SPDX-License-Identifier: MIT
"""Boards to be flashed: a virtual Uno with the genuine optiboot, on a pseudo-terminal of its own.

Each is a program of its own and runs paced, as the boot loader's one second is a second for
avrdude too. Its flash can be looked at when it has ended.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from virtual_uno.optiboot import optiboot_hex
from virtual_uno.program import FLASH_SIZE, read_hex, write_hex

TOP = Path(__file__).resolve().parents[2]
IMAGE = TOP / ".build" / "firmware" / "terazi.hex"
BOOT_ADDRESS = 0x7E00
END_S = 20.0


def flash_contents(hex_path) -> bytes:
    """A whole flash as a hex file has it, 0xFF where it says nothing."""
    flash = bytearray(b"\xff" * FLASH_SIZE)
    for address, data in read_hex(hex_path):
        flash[address : address + len(data)] = data
    return bytes(flash)


class FlashBoard:
    """A virtual Uno with a boot loader: `port` to program it by, `flash` once it has ended."""

    def __init__(self, folder: Path, *, boot="optiboot", program: Path | None = None):
        self.port = str(folder / "uno")
        self._image = folder / "flash.hex"
        command = [sys.executable, "-m", "virtual_uno", "--boot", str(boot)]
        command += ["--link", self.port, "--flash-image", str(self._image)]
        command += ["--elf", str(program)] if program else []
        path = os.pathsep.join([str(TOP / "hil_tests"), str(TOP / ".build" / "bench")])
        self.process = subprocess.Popen(
            command,
            env={**os.environ, "PYTHONPATH": path},
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        if not self.process.stdout.readline().startswith("/dev/"):
            raise RuntimeError(f"the virtual Uno did not start: {' '.join(command)}")

    def end(self) -> None:
        """Switch it off; its flash keeps what it holds. A cable pulled looks the same."""
        self.process.terminate()
        self.process.wait(END_S)
        self.process.stdout.close()

    @property
    def flash(self) -> bytes:
        if self.process.returncode is None:
            self.end()
        return flash_contents(self._image)


@pytest.fixture
def new_board(tmp_path):
    """new_board(): a board; again in the same test: a board with the flash of the one before."""
    boards = []

    def new_board(**how) -> FlashBoard:
        boards.append(FlashBoard(tmp_path, **how))
        return boards[-1]

    yield new_board
    for board in boards:
        if board.process.returncode is None:
            board.process.kill()
            board.process.wait(END_S)
            board.process.stdout.close()


@pytest.fixture
def board(new_board) -> FlashBoard:
    """A board with nothing on it but the boot loader."""
    return new_board()


@pytest.fixture(scope="session")
def image(tmp_path_factory) -> Path:
    """The genuine firmware; a copy, as it may be built anew while tests run."""
    if not IMAGE.exists():
        pytest.fail("there is no firmware image: make -C firmware", pytrace=False)
    return Path(shutil.copy(IMAGE, tmp_path_factory.mktemp("image")))


@pytest.fixture(scope="session")
def written(image) -> bytes:
    """What the flash must hold once the firmware is on it: the image and the boot loader."""
    application = flash_contents(image)[:BOOT_ADDRESS]
    return application + flash_contents(optiboot_hex())[BOOT_ADDRESS:]


@pytest.fixture
def boot_of_mega(tmp_path) -> Path:
    """Optiboot that gives the signature of an ATmega2560, and is otherwise the Uno's own."""
    code = flash_contents(optiboot_hex())
    for uno, mega in ((0x1E, 0x1E), (0x95, 0x98), (0x0F, 0x01)):
        # Each byte is in an `ldi r24, byte` of its own: 1110 KKKK dddd KKKK, r24 = 1000.
        old, new = (bytes((0x80 | byte & 15, 0xE0 | byte >> 4)) for byte in (uno, mega))
        places = [m.start() for m in re.finditer(re.escape(old), code[BOOT_ADDRESS:])]
        assert len(places) == 1, "this optiboot holds its signature otherwise"
        place = BOOT_ADDRESS + places[0]
        code = code[:place] + new + code[place + 2 :]
    path = tmp_path / "boot_of_mega.hex"
    write_hex(path, code)
    return path


def run_terazi(*arguments, cwd=TOP, env=None) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "terazi", *map(str, arguments)]
    return subprocess.run(
        command, cwd=cwd, env=env, capture_output=True, text=True, stdin=subprocess.DEVNULL
    )


@pytest.fixture
def terazi():
    """terazi(arguments...): the command, run to its end."""
    return run_terazi
