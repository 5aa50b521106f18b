# SPDX-License-Identifier: MIT
"""The genuine firmware, through the genuine boot loader, by each of the three ways there are."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from terazi.link import open_link
from virtual_uno.program import read_hex

TOP = Path(__file__).resolve().parents[2]
SETUP_PLATFORMIO = TOP / "tools" / "flash" / "setup_platformio.py"
# A closed port of this machine: whatever reaches for the network fails at once.
NOWHERE = "http://127.0.0.1:9"


def said_version(port) -> str:
    with open_link(port) as link:
        hello = link.hello(8.0)
    return f"{hello.version_major}.{hello.version_minor}.{hello.version_patch}"


def test_unmodified_avrdude_programs_a_blank_board(board, image, written):
    command = ["avrdude", "-p", "atmega328p", "-c", "arduino", "-P", board.port]
    command += ["-b", "115200", "-D", "-U", f"flash:w:{image}:i"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "bytes of flash verified" in done.stderr
    assert said_version(board.port)
    assert board.flash == written


def test_terazi_flash_programs_a_blank_board(board, image, written, terazi):
    done = terazi("flash", board.port, "--hex", image)
    assert done.returncode == 0, done.stderr
    before, after, wrote = done.stdout.splitlines()
    assert before.split(maxsplit=1) == ["before", "no Terazi firmware answered"]
    assert after.split()[:2] == ["after", "Terazi"]
    assert after.split()[2] == said_version(board.port)
    assert wrote.endswith(f"bytes of {image} at {board.port}")
    stages = ["asking who is there ...", "waking the boot loader ...", "writing ..."]
    stages += ["verifying ...", "waiting for the new firmware ..."]
    assert done.stderr.splitlines() == stages
    assert board.flash == written


@pytest.fixture
def clone(tmp_path, image) -> Path:
    """What makes a clone of the sources for `terazi flash`, its image where ./dev builds it."""
    for folder in ("firmware", "shared_c", ".build/firmware"):
        (tmp_path / "clone" / folder).mkdir(parents=True)
    (tmp_path / "clone" / "firmware" / "Makefile").touch()
    shutil.copy(image, tmp_path / "clone" / ".build" / "firmware" / "terazi.hex")
    return tmp_path / "clone"


def test_terazi_flash_in_a_clone_knows_its_image_and_names_the_version_that_was_there(
    new_board, clone, image, written, terazi
):
    board = new_board(program=image)
    done = terazi("flash", board.port, cwd=clone / "shared_c")
    assert done.returncode == 0, done.stderr
    before, after, _wrote = done.stdout.splitlines()
    assert before.removeprefix("before").split() == after.removeprefix("after").split()
    assert before.split()[1] == "Terazi"
    assert board.flash == written
    (log,) = (clone / ".build" / "flash").iterdir()
    assert "bytes of flash verified" in log.read_text()


@pytest.fixture
def pio(tmp_path):
    """pio(arguments...): PlatformIO without registry and network, in a build folder of its own."""

    def pio(*arguments, **environment):
        env = {**os.environ, "PLATFORMIO_BUILD_DIR": str(tmp_path / "pio"), **environment}
        env.update(http_proxy=NOWHERE, https_proxy=NOWHERE, no_proxy="")
        return subprocess.run(
            [sys.executable, str(SETUP_PLATFORMIO), *arguments],
            cwd=TOP,
            env=env,
            capture_output=True,
            text=True,
            stdin=subprocess.DEVNULL,
        )

    return pio


def test_pio_upload_programs_a_blank_board(board, pio, tmp_path, written):
    done = pio("run", "-e", "uno-virtual", "-t", "upload", "--upload-port", board.port)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "bytes of flash verified" in done.stdout + done.stderr
    assert said_version(board.port)
    pieces = read_hex(tmp_path / "pio" / "uno-virtual" / "firmware.hex")
    flash = board.flash
    assert all(flash[at : at + len(data)] == data for at, data in pieces)
    assert sum(len(data) for _at, data in pieces) == len(flash[:0x7E00].rstrip(b"\xff"))
    assert flash[0x7E00:] == written[0x7E00:]


def test_hex_of_platformio_is_the_makefiles(pio, tmp_path):
    build = "0x1234abcd"
    make = ["make", "-C", str(TOP / "firmware"), f"OUT={tmp_path / 'make'}", f"BUILD={build}"]
    subprocess.run(make, check=True, capture_output=True)
    done = pio("run", "-e", "uno-system", TERAZI_BUILD=build)
    assert done.returncode == 0, done.stdout + done.stderr
    made = (tmp_path / "make" / "terazi.hex").read_bytes()
    equal = (tmp_path / "pio" / "uno-system" / "firmware.hex").read_bytes() == made
    assert equal  # a difference of two images would take pytest minutes to print
