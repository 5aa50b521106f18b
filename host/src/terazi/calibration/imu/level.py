# SPDX-License-Identifier: MIT
"""How the IMU stands on its board: the board lies as it will in use, and the vertical is its z.

Which way its x looks, gravity does not tell: the part's x stays the board's, or else its y. The
magnetometer turns along, so that both go on agreeing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from terazi.applications.attitude.calibrated import measured, setting_names
from terazi.calibration.imu import positions
from terazi.calibration.imu.axes import NAMES, turn_of
from terazi.calibration.imu.board import ImuBoard
from terazi.calibration.imu.standstill import STILL_S, Finder
from terazi.calibration.terminal import Terminal
from terazi.control.balance import Balance
from terazi.control.settings import apply_settings, read_settings
from terazi.errors import CalibrationRefused
from terazi.link import Link
from terazi.link.generated.messages import SaveSettings

CODES = ("imu.orientation", "mag.orientation")
OFF_MOST_DEG = 30.0  # of the nearest axis from the vertical
TURN_S = 0.1


@dataclass(frozen=True)
class Level:
    """Codes of both orientations, and how far the part's axis stands off the vertical then."""

    imu_code: int
    mag_code: int
    off_deg: float

    @property
    def settings(self) -> dict[str, int]:
        """By name."""
        return dict(zip(CODES, (self.imu_code, self.mag_code), strict=True))


def find_level(up: np.ndarray, imu_code: int, mag_code: int) -> Level:
    """up : (3,) calibrated, the part's own axes, of a board that lies as in use.

    imu_code, mag_code : the present ones. Raises CalibrationRefused: at a slant.
    """
    up = up / np.linalg.norm(up)
    axis = np.zeros(3)
    at = int(np.argmax(np.abs(up)))
    axis[at] = np.sign(up[at])
    off_deg = float(np.degrees(np.arccos(min(abs(up[at]), 1.0))))
    if off_deg > OFF_MOST_DEG:
        raise CalibrationRefused(
            f"the board lies with {positions.name_of(up)}, {off_deg:.0f} deg off its nearest axis",
            remedy="Put it as it will stand in use, level; the IMU must be square to it.",
        )
    turns = {code: turn_of(code) for code in NAMES}
    fit = [code for code, turn in turns.items() if np.array_equal(turn @ axis, (0, 0, 1))]
    if imu_code in fit:
        return Level(imu_code, mag_code, off_deg)
    ahead = np.eye(3)[1 if at == 0 else 0]
    (best,) = (code for code in fit if np.array_equal(turns[code] @ ahead, (1, 0, 0)))
    also = turns[best] @ turn_of(imu_code).T @ turn_of(mag_code)
    (mag_best,) = (code for code, turn in turns.items() if np.array_equal(turn, also))
    return Level(best, mag_best, off_deg)


def set_level(
    link: Link, terminal: Terminal, *, asks: bool, wait_s: float, dry_run: bool = False
) -> Level:
    """The whole conversation. Raises CalibrationRefused, and what the link raises."""
    terminal.tell("Put the board as it will stand in use, level, and let it lie still for 3 s.")
    balance = Balance(link)
    balance.quiet_stream()  # a line that is full of attitudes has no room for answers
    now = read_settings(link, [*setting_names("acc"), *CODES])
    with ImuBoard(link) as board:
        raw = _still(board, terminal, wait_s)
    up = measured("acc", now, raw).mean(axis=0)
    found = find_level(up, *(now[name] for name in CODES))
    terminal.tell(
        f"The part lies with {positions.name_of(up / np.linalg.norm(up))}, {found.off_deg:.2f} deg "
        "off the vertical."
    )
    changes = {name: value for name, value in found.settings.items() if value != now[name]}
    for name, value in changes.items():
        terminal.tell(f"{name}: {NAMES.get(now[name], now[name])} -> {NAMES[value]}")
    if not changes:
        terminal.tell(f"It stands as {CODES[0]} says: {NAMES[now[CODES[0]]]}.", tone="good")
        return found
    choices = {"save": "so it stands from now on", "leave": "leave the board as it is"}
    if dry_run or (asks and terminal.choose("What now?", choices) != "save"):
        return found
    balance.quiet_stream()
    apply_settings(link, changes)
    balance.obey(SaveSettings())
    balance.wait_saved()
    terminal.tell("Saved.", tone="good")
    return found


def _still(board: ImuBoard, terminal: Terminal, wait_s: float) -> np.ndarray:
    """Raw accelerations of the first standstill."""
    board.forget()
    finder, fed = Finder(board.rate_hz), 0
    end_s = board.link.now_s() + wait_s
    while not finder.found:
        board.follow(TURN_S)
        acc, gyro = board.newest(fed)
        fed += len(acc)
        finder.feed(acc, gyro)
        terminal.live(f"lies still, {min(finder.still_s, STILL_S):.1f} of {STILL_S:g} s")
        if not finder.found and board.link.now_s() > end_s:
            terminal.live("")
            raise CalibrationRefused(
                f"it does not lie still: it moves by {finder.shake_deg_s:.1f} deg/s",
                remedy="Put it on something firm, or give it longer with --wait.",
            )
    terminal.live("")
    one = finder.found[0]
    acc, _gyro = board.newest(0)
    return acc[one.first : one.last]
