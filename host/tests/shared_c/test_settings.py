# SPDX-License-Identifier: MIT
"""settings: vectors, laws of keys and records, and the law that no record is ever half."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.tests.shared_c.eeproms import FAILED, IDLE, SIZE, Eeprom, PowerCut, save
from terazi.cshared.settings import (
    Settings,
    SettingsCell,
    SettingsReading,
    SettingsStatus,
    choose_settings,
)
from terazi.link.generated.settings import SETTINGS
from terazi.models import settings as twin
from terazi.models.vectors import golden

pytestmark = pytest.mark.no_cover  # millions of steps of a twin that other tests cover too

KEYS = [twin.Entry.of(one) for one in SETTINGS]
ONE_OF_EACH = st.tuples(*(st.integers(entry.minimum, entry.maximum) for entry in KEYS))
RECORD_LEN = len(twin.record(KEYS, twin.factory(KEYS), 1))
FACTORY = twin.payload(KEYS, twin.factory(KEYS))
BLANK = bytes([twin.ERASED])
# Written by version 1; keys that came since stay at the factory's.
FIRST_RECORD = (
    "5401ae67123fb64c040aeb36125b2d1e1bc627ac1978d7701869e213081f1aa6200003047803082d"
    "99bff58c2e07d8822ce43ca8c741c78d82ca2386d2c92ea6058ac02de50432502a3ef33f5160108d"
    "ba83154ca5d6f030100808c77ebde8ce97e31b645f83f6b7ca27e4dcdcb6000002beaf0601007f64"
    "601c51b30c384f1b3c0063bb1f00426c04000417df111afba90802f89492a835aa202f0a755980c5"
    "bac48a2a3f9e99d900a7187bc01700e5bd270856dd"
)
FIRST_WORDS = (
    "72136255 305589002 454962523 430712774 410048376 135520873 547756575 0 3 4 120 3 8 "
    "-171992787 -670617972 1021586562 -951990360 600474253 784978566 -1064696410 839181613 "
    "-214029744 274747711 360954509 -254368436 134746160 -390234425 467900366 -159162524 "
    "-467154249 11984092 0 2 44990 6 1 0 476079231 940356433 3939151 2079587 289858 4 23 "
    "-82177569 -134084439 900240020 170860714 -981444235 713737402 -644243905 0 6311 "
    "1556603 -16923 2087"
)
FIRST_VALUES = [int(word) for word in FIRST_WORDS.split()]
cells = st.integers(0, 255)


def settings_of(values) -> Settings:
    """Settings with these values, those too that no key writes."""
    settings = Settings()
    reading, _ = settings.read(twin.record(KEYS, values, 1))
    assert reading == SettingsReading.WHOLE
    return settings


def slot_of(record: bytes) -> bytes:
    return record.ljust(twin.SLOT_LEN, BLANK)


# --- vectors ---


def test_settings_read_every_slot_of_the_vectors_as_the_twin_does():
    (vector,) = golden("settings_records")
    rows = zip(*(vector[name] for name in ("slot_hex", "reading", "sequence")), strict=True)
    for (slot, reading, sequence), values in zip(rows, vector["values_hex"], strict=True):
        settings = Settings()
        got = settings.read(slot)
        assert got[0] == reading
        if reading in (twin.Reading.WHOLE, twin.Reading.FOREIGN):
            assert got[1] == sequence
        assert twin.payload(KEYS, settings.values) == values + FACTORY[len(values) :]


def test_settings_take_and_refuse_every_value_of_the_vectors():
    (vector,) = golden("settings_keys")
    settings = Settings()
    for key, asked, status in zip(*(vector[name] for name in vector.columns), strict=True):
        before = settings.get(key)
        assert settings.set(key, asked) == status, (key, asked)
        assert settings.get(key) == (asked if status == twin.Status.OK else before), (key, asked)


def readings_of(vector):
    for row in zip(*vector.columns.values(), strict=True):
        yield list(zip(row[0:8:2], row[1:8:2], strict=True)), row[8:]


def slot_with(reading: int, sequence: int) -> bytes:
    body = twin.payload(KEYS, twin.factory(KEYS))
    if reading == twin.Reading.NO_RECORD:
        return BLANK * twin.SLOT_LEN
    spoil = reading == twin.Reading.ROTTEN
    version = 2 if reading == twin.Reading.FOREIGN else 1
    slot = bytearray(slot_of(twin.frame(body, sequence, version)))
    slot[9] ^= spoil
    return bytes(slot)


def test_settings_choose_among_slots_as_the_vectors_say():
    (vector,) = golden("settings_choices")
    for readings, wanted in readings_of(vector):
        assert tuple(choose_settings([slot_with(*one) for one in readings])) == wanted


# --- keys ---


def test_settings_leave_the_factory_as_the_table_says():
    assert Settings().values == [one.default for one in SETTINGS]


@given(values=ONE_OF_EACH, calibration=st.booleans())
def test_settings_reset_spares_what_a_calibration_writes_unless_told(values, calibration):
    settings, wanted = settings_of(values), list(values)
    settings.reset(calibration=calibration)
    twin.reset(KEYS, wanted, calibration)
    assert settings.values == wanted


@given(values=ONE_OF_EACH, key=st.integers(0, 255), value=st.integers(-(1 << 31), (1 << 31) - 1))
def test_a_set_changes_its_own_key_only_and_only_within_its_range(values, key, value):
    settings, wanted = settings_of(values), list(values)
    assert settings.set(key, value) == twin.put(KEYS, wanted, key, value)
    assert settings.values == wanted


# --- records ---


@given(values=ONE_OF_EACH, sequence=st.integers(0, 65535))
def test_a_record_gives_back_what_it_was_made_of(values, sequence):
    record = settings_of(values).record(sequence)
    assert record == twin.record(KEYS, values, sequence)
    settings = Settings()
    assert settings.read(record) == (SettingsReading.WHOLE, sequence)
    assert settings.values == list(values)


@given(
    values=ONE_OF_EACH, flips=st.lists(st.integers(8, 8 * RECORD_LEN - 1), min_size=1, max_size=3)
)
def test_up_to_three_bits_that_change_are_seen_and_no_value_is_taken(values, flips):
    """CRC-16/MCRF4XX has distance 4 up to 32751 bits; a length that changes moves the CRC."""
    spoilt = bytearray(slot_of(twin.record(KEYS, values, 77)))
    for bit in set(flips):
        spoilt[bit // 8] ^= 1 << bit % 8
    settings = Settings()
    reading, _ = settings.read(bytes(spoilt))
    length_changed = any(bit // 8 == 2 for bit in set(flips))
    if not length_changed:
        assert reading == SettingsReading.ROTTEN
    assert reading == twin.read(KEYS, bytes(spoilt))[0]
    if reading != SettingsReading.WHOLE:
        assert settings.values == Settings().values


@given(slot=st.binary(min_size=256, max_size=256), has_magic=st.booleans())
def test_any_bytes_are_read_as_the_contract_says(slot, has_magic):
    slot = bytes([twin.MAGIC]) + slot[1:] if has_magic else slot
    settings = Settings()
    reading, _ = settings.read(slot)
    wanted, _, values = twin.read(KEYS, slot)
    assert reading == wanted
    assert settings.values == (values or Settings().values)


@given(values=ONE_OF_EACH, known=st.integers(0, len(KEYS)))
def test_an_older_firmwares_record_gives_what_it_has_and_the_rest_stays(values, known):
    record = twin.record(KEYS[:known], values[:known], 3)
    settings = Settings()
    assert settings.read(slot_of(record)) == (SettingsReading.WHOLE, 3)
    assert settings.values == [*values[:known], *twin.factory(KEYS)[known:]]


@given(values=ONE_OF_EACH, more=st.binary(min_size=1, max_size=249 - len(FACTORY)))
def test_a_newer_firmwares_record_is_foreign_and_changes_nothing(values, more):
    settings = Settings()
    newer = slot_of(twin.frame(twin.payload(KEYS, values) + more, 3))
    assert settings.read(newer) == (SettingsReading.FOREIGN, 3)
    other = slot_of(twin.frame(twin.payload(KEYS, values), 4, version=twin.VERSION + 1))
    assert settings.read(other) == (SettingsReading.FOREIGN, 4)
    assert settings.values == Settings().values


def test_a_newer_firmwares_record_is_not_passed_over_for_an_older_one():
    """What was calibrated last is not there for this firmware; what was before is not it."""
    older = slot_of(twin.record(KEYS, twin.factory(KEYS), 8))
    newer = slot_of(twin.frame(FACTORY + b"\0", 9))
    blank = BLANK * twin.SLOT_LEN
    assert choose_settings([older, newer, blank, blank]) == (SettingsReading.FOREIGN, 1, 0, 9)


# --- saving ---


@given(first=ONE_OF_EACH, second=ONE_OF_EACH)
def test_a_save_writes_only_cells_that_differ_and_each_of_them_once(first, second):
    eeprom = Eeprom()
    for values in (first, second, first, second, first):
        save(eeprom, settings_of(values))
    before = bytes(eeprom.cells)
    eeprom.writes.clear()
    saving = save(eeprom, settings_of(second))
    slot = choose_settings(eeprom.slots).slot * twin.SLOT_LEN
    wanted = twin.record(KEYS, second, saving.sequence)
    body = [
        (slot + at, byte, SettingsCell.REPLACE)
        for at, byte in enumerate(wanted)
        if at and before[slot + at] != byte
    ]
    first_write, *between, last = eeprom.writes
    assert first_write == (slot, twin.ERASED, SettingsCell.ERASE)
    assert between == body
    assert last == (slot, twin.MAGIC, SettingsCell.PROGRAM)
    assert eeprom.cells[slot : slot + RECORD_LEN] == wanted
    assert saving.state == IDLE


def test_a_thousand_saves_wear_all_slots_alike_and_no_cell_more_than_once_in_four():
    eeprom, settings = Eeprom(), Settings()
    for number in range(1000):
        settings.set(0, 1_000_000 + number)
        save(eeprom, settings)
    worn = [max(eeprom.wears[at : at + twin.SLOT_LEN]) for at in range(0, SIZE, twin.SLOT_LEN)]
    assert worn == [250] * twin.SLOTS


@given(old=ONE_OF_EACH, new=ONE_OF_EACH, earlier=st.integers(0, 5), data=st.data())
def test_a_power_cut_in_any_write_leaves_the_old_settings_or_the_new(old, new, earlier, data):
    """The cell in work holds anything then, and the save after it is cut, too."""
    eeprom = Eeprom()
    for number in range(earlier):
        save(eeprom, settings_of([1 + number, *new[1:]]))
    save(eeprom, settings_of(old))
    for _ in range(3):
        probe = Eeprom(bytes(eeprom.cells))
        save(probe, settings_of(new))
        cut_at, left = data.draw(st.integers(0, len(probe.writes) - 1)), data.draw(cells)
        with pytest.raises(PowerCut):
            save(eeprom, settings_of(new), cut_at=cut_at, left=left)
        reading, found = eeprom.load()
        assert reading == twin.Reading.WHOLE
        if left != twin.MAGIC:
            assert found.values == list(old)
        elif cut_at == len(probe.writes) - 1:
            assert found.values == list(new)
        else:  # a cell that reads as the magic by chance, before a record of another save
            assert found.values in (list(old), list(new))
        old = found.values
    save(eeprom, settings_of(new))
    assert eeprom.load()[1].values == list(new)


@given(values=ONE_OF_EACH, data=st.data())
def test_a_first_save_cut_anywhere_leaves_the_factorys_settings_or_the_new(values, data):
    probe = Eeprom()
    save(probe, settings_of(values))
    cut_at, left = data.draw(st.integers(0, len(probe.writes) - 1)), data.draw(cells)
    eeprom = Eeprom()
    with pytest.raises(PowerCut):
        save(eeprom, settings_of(values), cut_at=cut_at, left=left)
    reading, found = eeprom.load()
    completed = cut_at == len(probe.writes) - 1 and left == twin.MAGIC
    assert reading == (twin.Reading.WHOLE if completed else twin.Reading.NO_RECORD)
    assert found.values == (list(values) if completed else Settings().values)


@given(
    before=ONE_OF_EACH,
    changes=st.lists(st.tuples(st.integers(0, 700), ONE_OF_EACH), max_size=4),
)
def test_what_changes_in_mid_save_and_is_asked_for_is_saved_whole(before, changes):
    """Each change is of all values at once, as a calibration's is; the last one is saved."""
    eeprom, settings = Eeprom(), settings_of(before)
    last = list(before)

    def change(number, saving, live):
        nonlocal last
        for at, values in changes:
            if at == number:
                live.read(twin.record(KEYS, values, 1))
                saving.ask()
                last = list(values)

    saving = save(eeprom, settings, meanwhile=change)
    reading, found = eeprom.load()
    assert (saving.state, reading) == (IDLE, twin.Reading.WHOLE)
    assert found.values == last


def test_a_value_asked_for_at_any_step_of_a_save_is_saved():
    """The record's first value: what passes over it has passed it long before most of the steps."""
    steps = 0

    def count(number, _saving, _live):
        nonlocal steps
        steps = number

    used = Eeprom()
    values = FIRST_VALUES + twin.factory(KEYS)[len(FIRST_VALUES) :]
    for number in range(5):
        save(used, settings_of([1 + number, *values[1:]]))
    save(Eeprom(bytes(used.cells)), settings_of(values), meanwhile=count)
    for step in range(steps):

        def change(number, saving, live, step=step):
            if number == step:
                assert live.set(0, 4_321_987) == SettingsStatus.OK
                saving.ask()

        eeprom = Eeprom(bytes(used.cells))
        save(eeprom, settings_of(values), meanwhile=change)
        assert eeprom.load()[1].get(0) == 4_321_987, f"asked for at step {step} of {steps}"


@given(changes=st.lists(st.tuples(st.integers(0, 700), st.integers(1, 10**8)), max_size=4))
def test_a_value_that_changes_in_mid_save_is_never_saved_by_halves(changes):
    """Without being asked for, it is saved or not."""
    eeprom, settings = Eeprom(), Settings()

    def change(number, _saving, live):
        for at, value in changes:
            if at == number:
                live.set(0, value)

    save(eeprom, settings, meanwhile=change)
    assert eeprom.load()[1].get(0) in {Settings().get(0), *(value for _, value in changes)}


@given(
    old=ONE_OF_EACH,
    new=ONE_OF_EACH,
    stuck=st.dictionaries(st.integers(0, SIZE - 1), cells, max_size=4),
)
def test_worn_out_cells_are_gone_round_or_the_save_fails_and_the_old_settings_stay(old, new, stuck):
    eeprom = Eeprom()
    save(eeprom, settings_of(old))
    home = choose_settings(eeprom.slots).slot
    eeprom.stuck = {at: cell for at, cell in stuck.items() if at // twin.SLOT_LEN != home}
    for at, cell in eeprom.stuck.items():
        eeprom.cells[at] = cell

    def hold(*_):
        for at, cell in eeprom.stuck.items():
            eeprom.cells[at] = cell

    saving = save(eeprom, settings_of(new), meanwhile=hold)
    _, found = eeprom.load()
    assert found.values == list(old if saving.state == FAILED else new)
    bad = {at // twin.SLOT_LEN for at in eeprom.stuck}
    if saving.state == FAILED:
        assert len(bad) == twin.SLOTS - 1
    assert len(eeprom.writes) <= (1 + twin.SLOTS) * 255


def test_a_record_of_the_first_firmware_is_read_for_ever():
    settings = Settings()
    record = bytes.fromhex(FIRST_RECORD)
    assert settings.read(slot_of(record)) == (SettingsReading.WHOLE, 4711)
    known = len(FIRST_VALUES)
    assert settings.values == FIRST_VALUES + twin.factory(KEYS)[known:]
