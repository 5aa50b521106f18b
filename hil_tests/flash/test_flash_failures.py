# SPDX-License-Identifier: MIT
"""What goes wrong when a board is flashed is said in one clear line, with a fitting exit code."""

import os
import shutil
import subprocess
import sys
import time

import pytest
import serial

from virtual_uno.program import write_hex

USAGE, MISSING, BUSY, VANISHED, NO_ANSWER, CANNOT_READ, FAILED = 2, 3, 4, 5, 6, 9, 11


def assert_one_clear_line(done, code, *clues):
    """One line that says `error: ...` with all the clues, then at most one with the remedy."""
    assert done.returncode == code, done.stderr
    lines = done.stderr.splitlines()
    errors = [n for n, line in enumerate(lines) if line.startswith("error: ")]
    assert len(errors) == 1, done.stderr
    assert len(lines) - errors[0] <= 2, done.stderr
    for clue in clues:
        assert str(clue) in lines[errors[0]]
    assert done.stdout == ""


def wait_for_marks(folder, count, process):
    """Until avrdude's progress bar has so many marks of 50 in the log that lies in `folder`."""
    while process.poll() is None:
        if sum(log.read_text().count("#") for log in folder.glob("*.log")) >= count:
            return
        time.sleep(0.02)
    pytest.fail(f"ended before anything was written: {process.stderr.read()}")


def test_wrong_baud_is_named(board, image, terazi, written):
    done = terazi("flash", board.port, "--hex", image, "--baud", "57600")
    assert_one_clear_line(done, FAILED, "no boot loader answers", "57600 baud", board.port)
    assert "avrdude said: " in done.stderr
    assert board.flash[:0x7E00] == b"\xff" * 0x7E00


def test_wrong_part_is_named(new_board, boot_of_mega, image, terazi):
    board = new_board(boot=boot_of_mega)
    done = terazi("flash", board.port, "--hex", image)
    assert_one_clear_line(done, FAILED, "no ATmega328P", "0x1E9801", board.port)
    assert board.flash[:0x7E00] == b"\xff" * 0x7E00


def test_cable_pulled_while_writing_is_named_and_mended_by_flashing_again(
    new_board, image, terazi, written, tmp_path
):
    board = new_board()
    command = [sys.executable, "-m", "terazi", "flash", board.port, "--hex", str(image)]
    flashing = subprocess.Popen(
        command,
        cwd=tmp_path,
        env={**os.environ, "XDG_STATE_HOME": str(tmp_path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_for_marks(tmp_path / "terazi", 10, flashing)
    board.end()
    out, err = flashing.communicate()
    done = subprocess.CompletedProcess(command, flashing.returncode, out, err)
    assert_one_clear_line(done, VANISHED, board.port, "went away", "writing, at ")
    half = board.flash
    assert half != written
    assert half[:128] == written[:128]

    again = new_board()
    done = terazi("flash", again.port, "--hex", image)
    assert done.returncode == 0, done.stderr
    assert again.flash == written


def test_busy_port_is_named(board, image, terazi):
    with serial.Serial(board.port, exclusive=True):
        done = terazi("flash", board.port, "--hex", image)
    assert_one_clear_line(done, BUSY, board.port, "in use")


def test_missing_port_is_named(image, terazi, tmp_path):
    done = terazi("flash", tmp_path / "none", "--hex", image)
    assert_one_clear_line(done, MISSING, tmp_path / "none")


def test_firmware_of_somebody_else_is_written_but_named_as_silent(new_board, terazi, tmp_path):
    # Two instructions: rjmp to itself; and a nop, so that it is no empty image.
    idle = tmp_path / "idle.hex"
    idle.write_text(":04000000FFCF00002E\n:00000001FF\n")
    board = new_board()
    done = terazi("flash", board.port, "--hex", idle)
    assert_one_clear_line(done, NO_ANSWER, board.port, "programmed and verified")
    assert board.flash[:4] == b"\xff\xcf\x00\x00"


def test_image_too_large_is_refused_before_the_board_is_touched(board, terazi, tmp_path):
    path = tmp_path / "large.hex"
    write_hex(path, bytes(0x7E01))
    done = terazi("flash", board.port, "--hex", path)
    assert_one_clear_line(done, FAILED, path, "0x7E00")
    assert board.flash[:0x7E00] == b"\xff" * 0x7E00


@pytest.mark.parametrize("text", [None, "this is no hex file\n", ":0400000001020304F3\n"])
def test_unreadable_image_is_named(terazi, tmp_path, text):
    path = tmp_path / "image.hex"
    if text is not None:
        path.write_text(text)
    done = terazi("flash", tmp_path / "port", "--hex", path)
    assert_one_clear_line(done, CANNOT_READ, path)


def test_no_image_outside_the_sources_is_named(terazi, tmp_path):
    done = terazi("flash", tmp_path / "port", cwd=tmp_path)
    assert_one_clear_line(done, USAGE, "which image")
    assert "--hex" in done.stderr


def test_missing_avrdude_is_named(image, terazi, tmp_path):
    assert shutil.which("avrdude"), "the other tests here need it"
    done = terazi("flash", "port", "--hex", image, env={**os.environ, "PATH": str(tmp_path)})
    assert_one_clear_line(done, USAGE, "avrdude is not installed")
