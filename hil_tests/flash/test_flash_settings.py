# SPDX-License-Identifier: MIT
"""A firmware update leaves settings and calibration as they are: nobody touches the EEPROM."""

import subprocess

import pytest

from terazi.control import Balance
from terazi.link import open_link
from terazi.link.generated.messages import Point, SaveSettings
from terazi.settings import SettingsFile, apply_file, read_device

SETTINGS = {"scale.max_mg": 3_000_000, "chain.noise_limit_counts": 321}
POINTS = (Point(0, 1_000, 0), Point(1, 99_000_000, 2_000_000), Point(2, 200_000_000, 4_000_000))


def set_up(port) -> dict[str, int]:
    """Settings and a calibration of this board's own, saved; gives all that it holds."""
    with open_link(port) as link:
        link.hello(8.0)
        balance = Balance(link)
        apply_file(balance, SettingsFile(SETTINGS, POINTS))
        balance.obey(SaveSettings())
        balance.wait_saved()
        return read_device(link)


def held(port) -> dict[str, int]:
    with open_link(port) as link:
        link.hello(8.0)
        return read_device(link)


def by_avrdude(port, image, _terazi):
    command = ["avrdude", "-p", "atmega328p", "-c", "arduino", "-P", port, "-b", "115200", "-D"]
    done = subprocess.run(
        [*command, "-U", f"flash:w:{image}:i"], capture_output=True, text=True, check=False
    )
    assert "bytes of flash verified" in done.stderr


def by_terazi(port, image, terazi):
    done = terazi("flash", port, "--hex", image)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("flash", [by_avrdude, by_terazi])
def test_settings_and_calibration_survive_a_firmware_update(new_board, image, terazi, flash):
    board = new_board(program=image)
    before = set_up(board.port)
    assert before.items() >= SETTINGS.items()
    assert before["calibration.points"] == 3
    flash(board.port, image, terazi)
    assert held(board.port) == before
