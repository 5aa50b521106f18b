# SPDX-License-Identifier: MIT
"""The part's self-test: what excitement adds, beside what its trim codes promise.

PS-MPU-6000A-00 rev 3.4, p. 12, register map rev 4.2, pp. 9 to 12: at +-250 deg/s and +-8 g, of
code c, the gyroscope answers by 25 * 131 * 1.046^(c - 1), y the other way, the accelerometer by
4096 * 0.34 * (0.92 / 0.34)^((c - 1) / 30); within 14 %. An axis of code 0 was never trimmed and
passes. Siblings of the MPU-6050 lay their codes out otherwise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from terazi.calibration.imu.board import MODES, ImuBoard
from terazi.calibration.terminal import Terminal
from terazi.errors import CalibrationRefused
from terazi.link import Link

AXES = "xyz"
WITHIN = 0.14
SETTLE_S, AVERAGE_S = 0.4, 1.0
GYRO_COUNTS_DEG_S, ACC_COUNTS_G = 131.0, 4096.0
STILL_DEG_S, STILL_G = 2.0, 0.05  # rms; 1 kHz and 188 Hz make more noise than calibrating does
EVERY = 5
SAME_TRIMS = 3
MPU6050 = 0x68


@dataclass(frozen=True)
class Answer:
    """One axis of one sensor."""

    sensor: str
    axis: str
    code: int
    promised_counts: float  # 0 where the code is 0
    answered_counts: float

    @property
    def off(self) -> float | None:
        """Share by which it answers too much; None: nothing was promised."""
        return self.answered_counts / self.promised_counts - 1 if self.code else None

    @property
    def passes(self) -> bool:
        """Within 14 %, or never trimmed."""
        return self.off is None or abs(self.off) <= WITHIN


def codes(trim: Sequence[int]) -> tuple[list[int], list[int]]:
    """Of accelerometer and gyroscope, x y z. trim: SELF_TEST_X, Y, Z, A, registers 0x0D to 0x10."""
    low = [(trim[3] >> (4 - 2 * at)) & 3 for at in range(3)]
    acc = [((byte >> 5) << 2) | bits for byte, bits in zip(trim[:3], low, strict=True)]
    return acc, [byte & 0x1F for byte in trim[:3]]


def promised(sensor: str, axis: str, code: int) -> float:
    """Counts that a code stands for."""
    if not code:
        return 0.0
    if sensor == "accelerometer":
        return 4096 * 0.34 * (0.92 / 0.34) ** ((code - 1) / 30)
    return 25 * 131 * 1.046 ** (code - 1) * (-1 if axis == "y" else 1)


def judge(trim: Sequence[int], acc_counts, gyro_counts) -> list[Answer]:
    """All six axes. acc_counts, gyro_counts : (3,) means excited less means at rest."""
    answers = []
    sensors = zip(
        ("accelerometer", "gyroscope"), codes(trim), (acc_counts, gyro_counts), strict=True
    )
    for sensor, of_axes, counts in sensors:
        for axis, code, answered in zip(AXES, of_axes, counts, strict=True):
            wanted = promised(sensor, axis, code)
            answers.append(Answer(sensor, axis, code, wanted, float(answered)))
    return answers


def self_test(link: Link, terminal: Terminal) -> list[Answer]:
    """Run it on a board that lies still. Raises CalibrationRefused where it does not."""
    terminal.tell("The part tests itself: let the board lie still for 5 s.")
    with ImuBoard(link, mode="self_test_off", every=EVERY) as board:
        quiet = _means(board)
        board.set({"imu.mode": MODES["self_test_on"]})
        excited = _means(board)
        board.set({"imu.mode": MODES["trim"]})
        trim = _trim(board)
        status = board.status
    answers = judge(trim, excited[:3] - quiet[:3], excited[3:] - quiet[3:])
    rows = [
        (
            f"{one.sensor} {one.axis}",
            str(one.code),
            f"{one.promised_counts:.0f}" if one.code else "-",
            f"{one.answered_counts:.0f}",
            "never trimmed" if one.off is None else f"{one.off:+.1%}",
            "passes" if one.passes else "FAILS",
        )
        for one in answers
    ]
    terminal.table(("", "code", "promised", "answered", "off", ""), rows)
    if status is not None and status.identity != MPU6050:
        terminal.tell(
            f"WHO_AM_I is 0x{status.identity:02X}, no MPU-6050's: siblings lay their codes out "
            "otherwise, so that this says little.",
            tone="warn",
        )
    return answers


def want_all(answers: Sequence[Answer]) -> None:
    """Raises CalibrationRefused where an axis fails."""
    failed = [f"{one.sensor} {one.axis} ({one.off:+.0%})" for one in answers if not one.passes]
    if failed:
        raise CalibrationRefused(
            f"the self-test fails: {', '.join(failed)}; {WITHIN:.0%} are allowed",
            remedy="Repeat it with the board lying still. A part that goes on failing was dropped "
            "or is a poor copy: do not trust its calibration.",
        )


def _means(board: ImuBoard) -> np.ndarray:
    """(6,) of accelerations and rates while nothing moves."""
    board.follow(SETTLE_S)
    board.forget()
    board.follow(AVERAGE_S)
    acc, gyro = board.newest(0)
    if len(acc) < 10:
        raise CalibrationRefused(
            "hardly any samples come while the part tests itself", remedy="Try again."
        )
    shakes = (acc.std(axis=0).max() / ACC_COUNTS_G, gyro.std(axis=0).max() / GYRO_COUNTS_DEG_S)
    if shakes[0] > STILL_G or shakes[1] > STILL_DEG_S:
        raise CalibrationRefused(
            f"the board moves: {shakes[0] * 1000:.0f} mg, {shakes[1]:.1f} deg/s rms",
            remedy="Let it lie on something firm until the test is over.",
        )
    return np.concatenate([acc.mean(axis=0), gyro.mean(axis=0)])


def _trim(board: ImuBoard) -> list[int]:
    """Registers 0x0D to 0x10, which come in place of the accelerations."""
    board.follow(SETTLE_S)
    board.forget()
    board.follow(SETTLE_S)
    acc, _gyro = board.newest(0)
    if len(acc) < SAME_TRIMS or np.any(acc[-SAME_TRIMS:, :2] != acc[-1, :2]):
        raise CalibrationRefused("the trim codes do not read twice the same", remedy="Try again.")
    return [int(byte) for word in acc[-1, :2] for byte in divmod(int(word) & 0xFFFF, 256)]
