# SPDX-License-Identifier: MIT
"""Settings of the firmware as it ships: set, refused, saved, found again, whatever is cut."""

from itertools import pairwise

import pytest

from boards import RawCommand
from terazi.errors import CommandRefused
from terazi.link.generated.messages import (
    FaultFlag,
    GetInfo,
    GetSetting,
    ResetSettings,
    ResetWhat,
    Result,
    SaveSettings,
    SetSetting,
    Setting,
    SettingsState,
    Status,
)
from terazi.link.generated.settings import RECORD_PAYLOAD_LEN, SETTINGS, SettingKey
from terazi.models import settings as twin

KEYS = [
    twin.Entry(one.type, one.minimum, one.maximum, one.default, bool(one.by)) for one in SETTINGS
]
FACTORY = twin.factory(KEYS)
BLANK = b"\xff" * twin.SLOT_LEN
SAVE_S = 2.0  # a first save takes 0.65 s
STEP_S = 100e-6
EEAR = 0x41
CHANGES = {
    SettingKey.SCALE_MAX_MG: 3_000_000,
    SettingKey.SCALE_DIGIT: 5,
    SettingKey.CHECKWEIGHER_SETTLE_US: 1_000_000,
    SettingKey.TEMPERATURE_SPAN_PPM_PER_K_Q4: -321,
}


def get(uno, key):
    return uno.link.ask(GetSetting(key), Setting, key=key).value


def put(uno, key, value):
    assert uno.link.ask(SetSetting(key, value), Setting, key=key).value == value


def values(uno):
    return [get(uno, one.key) for one in SETTINGS]


def status(uno):
    return uno.link.ask(GetInfo(), Status)


def save(uno):
    """Save and wait for its end; gives the STATUS."""
    uno.link.command(SaveSettings())
    end_s = uno.link.now_s() + SAVE_S
    while (told := status(uno)).settings_state == SettingsState.WRITING:
        assert uno.link.now_s() < end_s, "a save without an end"
        uno.wait(0.02)
    return told


def restart(uno, cause="external"):
    uno.reset(cause)
    uno.link.stream.hello = None
    uno.link.hello()


def with_changes(old):
    new = list(old)
    for key, value in CHANGES.items():
        new[key] = value
    return new


def test_every_setting_is_told_and_an_unknown_key_is_refused(uno):
    uno.link.hello()
    for one in SETTINGS:
        assert one.minimum <= get(uno, one.key) <= one.maximum
    for command in (GetSetting(len(SETTINGS)), GetSetting(255), SetSetting(len(SETTINGS), 0)):
        assert uno.link.request(command).result == Result.NOTHING_THERE


def test_a_value_out_of_range_or_not_for_keys_is_refused_and_changes_nothing(uno):
    uno.link.hello()
    before = values(uno)
    for one in SETTINGS:
        for value in (one.minimum - 1, one.maximum + 1):
            if not -(1 << 31) <= value < 1 << 31:
                continue
            wanted = Result.WRITE_PROTECTED if one.by else Result.OUT_OF_RANGE
            assert uno.link.request(SetSetting(one.key, value)).result == wanted, one.full_name
    for payload in (b"", b"\0", b"\0" * 4, b"\0" * 6):
        refused = uno.link.request(RawCommand(SetSetting.ID, payload))
        assert refused.result == Result.WRONG_LENGTH
    assert values(uno) == before


def test_settings_that_contradict_one_another_are_refused_by_name(uno):
    uno.link.hello()
    before = values(uno)
    with pytest.raises(CommandRefused) as refused:
        uno.link.command(SetSetting(SettingKey.SCALE_INTERVAL_MG, before[0] // 16 + 1))
    assert refused.value.result == Result.CONTRADICTS
    assert values(uno) == before


def test_what_is_saved_outlives_a_reset_and_what_is_not_does_not(uno):
    uno.link.hello()
    uno.link.command(ResetSettings(ResetWhat.ALL_BUT_CALIBRATION))
    first = save(uno).settings_saved
    put(uno, SettingKey.SCALE_DIGIT, 5)
    told = save(uno)
    assert (told.settings_state, told.settings_saved) == (SettingsState.IDLE, first % 65535 + 1)
    put(uno, SettingKey.SCALE_MAX_MG, 3_000_000)
    restart(uno)
    assert get(uno, SettingKey.SCALE_DIGIT) == 5
    assert get(uno, SettingKey.SCALE_MAX_MG) == FACTORY[SettingKey.SCALE_MAX_MG]
    uno.link.command(ResetSettings(ResetWhat.ALL_BUT_CALIBRATION))
    save(uno)


def test_weighing_goes_on_while_settings_are_written(uno):
    uno.link.hello()
    uno.samples(40)
    put(uno, SettingKey.SCALE_DIGIT, 2)
    uno.link.command(SaveSettings())
    conversions = [one.message.conversion for one in uno.samples(60)]
    assert all((b - a) % 65536 == 1 for a, b in pairwise(conversions))
    assert status(uno).conversions_missed == 0
    put(uno, SettingKey.SCALE_DIGIT, 1)
    save(uno)


def test_a_power_cut_in_any_eeprom_write_leaves_the_old_settings_or_the_new(uno):
    """Cut in each write of a save, and of the one that follows it, on the firmware that ships."""
    board = uno.truth("be cut from power in mid-write")
    records = [twin.record(KEYS, [*FACTORY[:-1], 10 + n], 3 + n) for n in range(4)]
    before = b"".join(record.ljust(twin.SLOT_LEN, b"\xff") for record in records)
    old = [*FACTORY[:-1], 13]
    new = with_changes(old)
    differing = sum(
        a != b for a, b in zip(twin.record(KEYS, new, 7), before[: len(records[0])], strict=True)
    )

    def begin(cells):
        """Start with this EEPROM, change settings, ask for a save."""
        board.eeprom.set(0, cells)
        restart(uno, "power_on")
        for key, value in CHANGES.items():
            put(uno, key, value)
        written = board.stats["eeprom_writes"]
        uno.link.send(SaveSettings())
        return written

    def into_write(count):
        board.run_until(lambda: board.stats["eeprom_writes"] >= count, SAVE_S, step_s=STEP_S)
        return int.from_bytes(board.peek(EEAR, 2), "little")

    found = []
    for write in range(1, differing + 3):
        cell = into_write(begin(before) + write)
        restart(uno, "power_on")
        left = board.eeprom.get()
        assert left[768:] == before[768:], "the newest record was touched"
        outcomes = [(left, values(uno))]
        for doubtful in (before[cell], before[cell] & 0x5A):
            board.eeprom.set(0, left)
            board.eeprom.set(cell, bytes([doubtful]))
            restart(uno, "power_on")
            outcomes.append((board.eeprom.get(), values(uno)))
        for cells, got in outcomes:
            assert got in (old, new), f"write {write}, cell {cell}"
            found.append(got)
            into_write(begin(cells) + 1 + write % 2)  # it has two at least
            restart(uno, "power_on")
            assert values(uno) in (old, new), f"the save after write {write}"
    assert found.count(old) > found.count(new)
    for key, value in CHANGES.items():
        put(uno, key, value)
    save(uno)
    restart(uno, "power_on")
    assert values(uno) == new


def test_the_first_save_of_a_new_board_can_be_cut_in_any_write(uno):
    board = uno.truth("be cut from power in mid-write")
    board.eeprom.set(0, BLANK * 4)
    writes = 1 + len(twin.record(KEYS, with_changes(FACTORY), 1).replace(b"\xff", b""))
    restart(uno, "power_on")
    for key, value in CHANGES.items():
        put(uno, key, value)
    before = board.stats["eeprom_writes"]
    uno.link.send(SaveSettings())
    left = []  # what a cut in this write leaves: all before it, for a cell changes at its end
    for write in range(1, writes + 1):
        board.run_until(
            lambda wanted=before + write: board.stats["eeprom_writes"] >= wanted,
            SAVE_S,
            step_s=STEP_S,
        )
        assert board.stats["eeprom_writes"] == before + write
        left.append(board.eeprom.get())
    assert len(set(left)) == writes - 1  # the first blanks what is blank
    restart(uno, "power_on")  # in the last one
    assert board.eeprom.get() == left[-1]
    for cells in left:
        board.eeprom.set(0, cells)
        restart(uno, "power_on")
        assert [get(uno, key) for key in CHANGES] == [FACTORY[key] for key in CHANGES]


def test_an_older_firmwares_calibration_is_kept_and_new_settings_are_the_factorys(uno):
    board = uno.truth("have its EEPROM written from outside")
    known = SettingKey.CHAIN_ORDER  # the first firmware might have known no more
    saved = list(FACTORY)
    saved[SettingKey.CALIBRATION_POINT_COUNTS_Q7_1] = 123_456_789
    saved[SettingKey.SCALE_MAX_MG] = 3_000_000
    record = twin.record(KEYS[:known], saved[:known], 41)
    board.eeprom.set(0, record.ljust(twin.SLOT_LEN, b"\xff") + BLANK * 3)
    restart(uno, "power_on")
    assert values(uno) == saved
    assert status(uno).settings_saved == 41


@pytest.mark.parametrize("kind", ["longer", "other version", "rotten"])
def test_a_record_that_cannot_be_read_is_told_as_a_fault_and_the_factorys_settings_hold(uno, kind):
    board = uno.truth("have its EEPROM written from outside")
    body = twin.payload(KEYS, with_changes(FACTORY))
    assert len(body) == RECORD_PAYLOAD_LEN
    records = {
        "longer": twin.frame(body + b"\0", 5),
        "other version": twin.frame(body, 5, version=2),
        "rotten": twin.frame(body, 5)[:9] + b"\xa5" + twin.frame(body, 5)[10:],
    }
    board.eeprom.set(0, records[kind].ljust(twin.SLOT_LEN, b"\xff") + BLANK * 3)
    restart(uno, "power_on")
    assert status(uno).faults & FaultFlag.SETTINGS_LOST
    assert values(uno) == FACTORY
    save(uno)
    assert not status(uno).faults & FaultFlag.SETTINGS_LOST


def test_a_new_board_has_the_factorys_settings_and_no_fault_of_settings(uno):
    board = uno.truth("be new")
    board.eeprom.set(0, BLANK * 4)
    restart(uno, "power_on")
    assert values(uno) == FACTORY
    assert status(uno).settings_saved == 0
    assert not status(uno).faults & FaultFlag.SETTINGS_LOST
