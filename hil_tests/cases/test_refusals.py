# SPDX-License-Identifier: MIT
"""Bad input to every command, in every state: refused by name, and nothing is other than before."""

from dataclasses import replace
from typing import get_args

import pytest

from boards import RawCommand
from terazi.link.generated.messages import (
    CalibrateAbort,
    CalibrateBegin,
    CalibrateEnd,
    CalibrateKnown,
    CalibratePoint,
    CountPieces,
    FaultFlag,
    GetInfo,
    GetPoint,
    GetSetting,
    Hello,
    Point,
    ResetCounts,
    ResetSettings,
    Result,
    SaveSettings,
    SetSetting,
    SetStream,
    SetTextMode,
    Setting,
    Show,
    Tare,
    TareClear,
    ToDevice,
    ToHost,
    View,
    Weight,
    WeightFlag,
    Zero,
)
from terazi.link.generated.settings import SETTINGS, SettingKey

COMMANDS = {command.ID: command for command in get_args(ToDevice)}
PAYLOAD_MAX = 48
NOBODYS = [number for number in range(256) if number not in COMMANDS]
KEYS = max(SettingKey) + 1

WRONG_LENGTH = [
    RawCommand(command.ID, bytes(length))
    for command in COMMANDS.values()
    for length in {0, command.LEN - 1, command.LEN + 1, PAYLOAD_MAX} - {-1, command.LEN}
]


def raw(command, *numbers):
    """A payload of numbers as the fields have them, whatever their ranges say."""
    widths = {1: (1,), 2: (2,), 4: (4,), 5: (1, 4), 8: (4, 4)}[command.LEN]
    packed = (
        (number % (1 << 8 * width)).to_bytes(width, "little")
        for number, width in zip(numbers, widths, strict=True)
    )
    return RawCommand(command.ID, b"".join(packed))


I32_MIN, I32_MAX = -(1 << 31), (1 << 31) - 1
OUT_OF_RANGE = [
    *(raw(SetStream, mask) for mask in (64, 128, 255)),
    *(raw(SetTextMode, on) for on in (2, 255)),
    *(raw(Show, view) for view in (3, 255)),
    raw(CountPieces, 0),
    *(raw(CalibratePoint, mass) for mass in (500_000_001, -500_000_001, I32_MIN, I32_MAX)),
    *(raw(CalibrateKnown, 0, mass) for mass in (500_000_001, -500_000_001, I32_MIN, I32_MAX)),
    *(raw(CalibrateKnown, at, 0) for at in ((1 << 30) + 1, -(1 << 30) - 1, I32_MIN, I32_MAX)),
    *(raw(GetPoint, index) for index in (8, 255)),
    *(raw(ResetSettings, what) for what in (2, 255)),
]
"""By messages.toml; these are refused so in every state."""

IN_A_CALIBRATION = [
    Tare(),
    TareClear(),
    Zero(),
    CountPieces(7),
    ResetCounts(),
    CalibrateBegin(),
    SetSetting(SettingKey.SCALE_DIGIT, 5),
    SetSetting(255, 0),
    SaveSettings(),
    ResetSettings(0),
    ResetSettings(1),
]
OUTSIDE_OF_ONE = [CalibratePoint(0), CalibrateKnown(0, 0), CalibrateEnd(), CalibrateAbort()]

BY_THE_COMMAND = [
    (GetSetting(KEYS), Result.NOTHING_THERE),
    (GetSetting(255), Result.NOTHING_THERE),
    (SetSetting(KEYS, 0), Result.NOTHING_THERE),
    (SetSetting(SettingKey.SCALE_MAX_MG, 0), Result.OUT_OF_RANGE),
    (SetSetting(SettingKey.SCALE_MAX_MG, I32_MIN), Result.OUT_OF_RANGE),
    (SetSetting(SettingKey.CHAIN_ORDER, 2), Result.OUT_OF_RANGE),
    (SetSetting(SettingKey.CHAIN_GAIN, 0), Result.OUT_OF_RANGE),
    (SetSetting(SettingKey.IMU_MODE, 6), Result.OUT_OF_RANGE),
    (SetSetting(SettingKey.IMU_EVERY, 0), Result.OUT_OF_RANGE),
    (SetSetting(SettingKey.IMU_ORIENTATION, 0), Result.CONTRADICTS),  # x and y along one axis
    (SetSetting(SettingKey.MAG_ORIENTATION, 11), Result.CONTRADICTS),  # x along no axis
    (SetSetting(SettingKey.UART_BAUD, 3), Result.OUT_OF_RANGE),
    (SetSetting(SettingKey.ACC_XX_Q16, 10_923), Result.OUT_OF_RANGE),
    (SetSetting(SettingKey.SCALE_DIGIT, 3), Result.CONTRADICTS),
    (SetSetting(SettingKey.SCALE_INTERVAL_MG, 400_000), Result.CONTRADICTS),
    (SetSetting(SettingKey.CHECKWEIGHER_LEAVE_MG, 1_000_000), Result.CONTRADICTS),
    (SetSetting(SettingKey.CALIBRATION_POINTS, 3), Result.WRITE_PROTECTED),
    (SetSetting(SettingKey.CALIBRATION_ZERO_MG, 0), Result.WRITE_PROTECTED),
    (GetPoint(2), Result.NOTHING_THERE),
    (ResetCounts(), Result.WRONG_STATE),
]


def last_weight(uno):
    """The scale's state, but for what noise alone may change."""
    weight = [one.message for one in uno.wait(0.3) if isinstance(one.message, Weight)][-1]
    lasting = WeightFlag.TARED | WeightFlag.ZEROED | WeightFlag.FROZEN
    return replace(
        weight,
        net_mg=round(weight.net_mg / 500_000),
        zero_mg=round(weight.zero_mg / 5_000),  # zero is tracked
        shown=round(weight.shown / 500),
        weight_flags=weight.weight_flags & lasting,
        faults=FaultFlag(0),
    )


def everything(uno):
    """All settings, all points, what WEIGHT and HELLO tell."""
    settings = [uno.link.ask(GetSetting(one.key), Setting, key=one.key).value for one in SETTINGS]
    points = []
    while uno.link.request(GetPoint(len(points))).result == Result.OK:
        points.append(uno.link.ask(GetPoint(len(points)), Point, index=len(points)))
    hello = replace(uno.link.ask(GetInfo(), Hello), converter_rate_hz_q16=0)
    return settings, points, last_weight(uno), hello


def assert_refused(uno, command, result):
    ack = uno.link.request(command)
    assert (ack.command, ack.result) == (command.ID, result), command


def put_into(uno, state):
    """A scale with all that a refused command could spoil."""
    uno.link.hello()
    uno.load(grams=0.0)
    uno.wait(2.0)
    uno.load(grams=1000.0)
    uno.wait(2.0)
    uno.link.command(CountPieces(50))
    uno.link.command(Tare())
    uno.load(grams=1500.0)
    uno.wait(2.0)
    uno.link.command(Show(View.PEAK))
    if state == "calibrating":
        uno.link.command(CalibrateBegin())
        uno.link.command(CalibrateKnown(-1_000_000, 0))
        uno.link.command(CalibrateKnown(90_000_000, 2_000_000))
    uno.wait(1.0)


@pytest.mark.parametrize("state", ["weighing", "calibrating"])
def test_unknown_commands_and_wrong_lengths_and_ranges_are_refused_by_name(uno, state):
    put_into(uno, state)
    before = everything(uno)
    for number in NOBODYS:
        assert_refused(uno, RawCommand(number), Result.UNKNOWN_COMMAND)
        assert_refused(uno, RawCommand(number, bytes(5)), Result.UNKNOWN_COMMAND)
    assert everything(uno) == before
    for command in WRONG_LENGTH:
        assert_refused(uno, command, Result.WRONG_LENGTH)
    assert everything(uno) == before
    for command in OUT_OF_RANGE:
        assert_refused(uno, command, Result.OUT_OF_RANGE)
    assert everything(uno) == before


def test_every_command_has_been_sent_with_a_wrong_length():
    assert {command.ID for command in WRONG_LENGTH} == set(COMMANDS)
    assert not {message.ID for message in get_args(ToHost)} & set(COMMANDS)


def test_in_the_middle_of_a_calibration_what_would_disturb_it_is_refused(uno):
    put_into(uno, "calibrating")
    before = everything(uno)
    for command in IN_A_CALIBRATION:
        assert_refused(uno, command, Result.CALIBRATING)
    after = everything(uno)
    assert after == before
    assert after[2].calibrating == 3
    assert [point.mass_mg for point in after[1]] == [0, 2_000_000]


def test_outside_of_a_calibration_its_commands_are_refused(uno):
    put_into(uno, "weighing")
    before = everything(uno)
    for command in OUTSIDE_OF_ONE:
        assert_refused(uno, command, Result.NOT_CALIBRATING)
    assert everything(uno) == before


@pytest.mark.parametrize(("command", "result"), BY_THE_COMMAND, ids=str)
def test_what_a_command_itself_refuses_changes_nothing(uno, command, result):
    put_into(uno, "weighing")
    before = everything(uno)
    assert_refused(uno, command, result)
    assert everything(uno) == before


def test_what_wants_a_load_that_stands_is_refused_while_it_moves(uno):
    put_into(uno, "weighing")
    uno.load(grams=lambda t_s: 1500.0 + 100.0 * (t_s % 4.0))
    uno.wait(1.0)
    before = uno.link.ask(GetInfo(), Hello), last_weight(uno).tare_mg, last_weight(uno).pieces > 0
    for command in (Tare(), Zero(), CountPieces(5)):
        assert_refused(uno, command, Result.NOT_STABLE)
    uno.link.command(CalibrateBegin())
    assert_refused(uno, CalibratePoint(1_000_000), Result.NOT_STABLE)
    assert last_weight(uno).calibrating == 1
    uno.link.command(CalibrateAbort())
    after = uno.link.ask(GetInfo(), Hello), last_weight(uno).tare_mg, last_weight(uno).pieces > 0
    assert after == before


def test_zero_and_pieces_beyond_their_ranges_are_refused(uno):
    uno.link.hello()
    uno.wait(2.0)
    assert_refused(uno, Tare(), Result.OUT_OF_RANGE)
    assert_refused(uno, CountPieces(5), Result.TOO_LIGHT)
    uno.load(grams=200.0)  # 4 % of Max
    uno.wait(2.0)
    assert_refused(uno, Zero(), Result.OUT_OF_RANGE)
    uno.load(grams=4.0)  # below 20 e
    uno.wait(2.0)
    assert_refused(uno, CountPieces(2), Result.TOO_LIGHT)
    weight = last_weight(uno)
    assert (weight.tare_mg, weight.pieces) == (0, 0)
