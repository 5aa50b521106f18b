# SPDX-License-Identifier: MIT
"""settings, store and EEPROM driver on the chip: golden vectors, and the power cut in every write.

The record of the settings in RAM is what is compared: it holds each value.
"""

import pytest

from target_vectors.avr_settings import SettingsChip
from terazi.link.generated.settings import SETTINGS, SettingKey
from terazi.models import settings as twin
from terazi.models.vectors import golden

KEYS = [twin.Entry.of(one) for one in SETTINGS]
FACTORY = twin.payload(KEYS, twin.factory(KEYS))
BLANK = bytes([twin.ERASED]) * twin.SLOT_LEN
SETTINGS_LEN = 256  # sizeof(settings_t) on the chip
IDLE, FAILED = 0, 2


@pytest.fixture(scope="module")
def chip(runner_settings_elf):
    return SettingsChip(runner_settings_elf)


def slots(*records: bytes) -> bytes:
    """An EEPROM with these in its slots, and nothing behind them."""
    full = [record.ljust(twin.SLOT_LEN, b"\xff") for record in records]
    return b"".join(full + [BLANK] * (twin.SLOTS - len(full)))


def body_of(chip) -> bytes:
    """The values in RAM, as a record holds them."""
    return chip.record(0)[twin.HEAD_LEN : -twin.CRC_LEN]


def test_settings_read_every_slot_of_the_vectors_on_avr(chip):
    (vector,) = golden("settings_records")
    rows = (vector[name] for name in ("slot_hex", "reading", "sequence", "values_hex"))
    for slot, reading, sequence, values in zip(*rows, strict=True):
        chip.eeprom = slot + BLANK * 3
        assert chip.load() == (reading, sequence)
        assert body_of(chip) == values + FACTORY[len(values) :]


def test_settings_take_and_refuse_every_value_of_the_vectors_on_avr(chip):
    (vector,) = golden("settings_keys")
    chip.reset(calibration=True)
    for key, asked, status in zip(*(vector[name] for name in vector.columns), strict=True):
        _, before = chip.get(key)
        after = asked if status == twin.Status.OK else before
        assert (chip.set(key, asked), chip.get(key)[1]) == (status, after), (key, asked)


def test_settings_choose_among_slots_as_the_vectors_say_on_avr(chip):
    (vector,) = golden("settings_choices")
    for row in zip(*vector.columns.values(), strict=True):
        cells = b""
        for slot, (reading, sequence) in enumerate(zip(row[0:8:2], row[1:8:2], strict=True)):
            values = twin.factory(KEYS)
            values[SettingKey.SCALE_MAX_MG] = 1_000_000 + slot
            version = twin.VERSION + (reading == twin.Reading.FOREIGN)
            record = bytearray(twin.frame(twin.payload(KEYS, values), sequence, version))
            record[9] ^= reading == twin.Reading.ROTTEN
            cells += BLANK if reading == twin.Reading.NO_RECORD else slots(bytes(record))[:256]
        chip.eeprom = cells
        reading, slot, rotten, sequence = row[8:]
        assert chip.load() == (twin.Reading.ROTTEN if rotten else reading, sequence)
        found = chip.get(SettingKey.SCALE_MAX_MG)[1]
        assert found == (1_000_000 + slot if reading == twin.Reading.WHOLE else 5_000_000)


def test_a_reset_spares_the_calibration_unless_told_on_avr(chip):
    some = [entry.minimum for entry in KEYS]
    chip.eeprom = slots(twin.record(KEYS, some, 1))
    for calibration in (False, True):
        chip.load()
        chip.reset(calibration=calibration)
        wanted = list(some)
        twin.reset(KEYS, wanted, calibration)
        assert body_of(chip) == twin.payload(KEYS, wanted)


def test_a_save_goes_to_the_slots_in_turn_and_is_found_again(chip):
    chip.eeprom = slots()
    assert chip.load() == (twin.Reading.NO_RECORD, 0)
    for number in range(1, 7):
        assert chip.set(SettingKey.SCALE_MAX_MG, 1_000_000 + number) == 0
        assert chip.save() == (IDLE, number)
        body = body_of(chip)
        record = twin.frame(body, number)
        at = (number - 1) % twin.SLOTS * twin.SLOT_LEN
        assert chip.eeprom[at : at + len(record)] == record
        assert chip.load() == (twin.Reading.WHOLE, number)
        assert body_of(chip) == body


def test_the_sequence_wraps_and_leaves_out_zero(chip):
    chip.eeprom = slots(twin.record(KEYS, twin.factory(KEYS), 65535))
    chip.load()
    assert chip.save() == (IDLE, 1)
    assert chip.load() == (twin.Reading.WHOLE, 1)


USED = [
    twin.record(KEYS, [entry.minimum for entry in KEYS], 5),
    twin.record(KEYS, twin.factory(KEYS), 6),
    twin.record(KEYS, [*twin.factory(KEYS)[:-1], 77], 3),
    twin.record(KEYS, [*twin.factory(KEYS)[:-1], 99], 4),
]


CHANGES = (
    (SettingKey.SCALE_MAX_MG, 3_000_000),
    (SettingKey.SCALE_UNIT, 1),
    (SettingKey.SCALE_DIGIT, 5),
    (SettingKey.CHECKWEIGHER_SETTLE_US, 1_000_000),
    (SettingKey.TEMPERATURE_SPAN_PPM_PER_K_Q4, -321),
)


def doubtful_values(cell_left: int, was: int, to_be: int) -> list[int]:
    """What a cell may hold whose write was cut: as the chip leaves it, as it was, as it was to be,
    half-written."""
    return sorted({cell_left, was, to_be, was & to_be, was | to_be, 0x00})


def test_a_power_cut_in_any_eeprom_write_leaves_the_old_settings_or_the_new(chip):
    """The power goes in each write of a save, and again in the save that follows; then one is
    done."""
    before = slots(*USED)
    chip.eeprom = before
    chip.load()
    old = body_of(chip)
    assert not any(chip.set(key, value) for key, value in CHANGES)
    in_ram, new = chip.peek(SETTINGS_LEN), body_of(chip)
    record = twin.frame(new, 7)

    def cut_in(write, cells):
        """A save from this EEPROM, cut in that write; False where it ended before."""
        chip.eeprom = cells
        assert chip.load()[0] == twin.Reading.WHOLE
        chip.poke(in_ram)
        chip.begin_save()
        return chip.into_write(write)

    write, outcomes = 1, []
    while cut_in(write, before):
        cell = chip.cell_in_work
        chip.cut_power()
        left = chip.eeprom
        assert left[256:512] == before[256:512], "the newest record was touched"
        # The first write erases the magic, the last one programs it.
        to_be = twin.ERASED if write == 1 else record[cell % twin.SLOT_LEN]
        for doubtful in doubtful_values(left[cell], before[cell], to_be):
            chip.eeprom = left[:cell] + bytes([doubtful]) + left[cell + 1 :]
            assert chip.load()[0] == twin.Reading.WHOLE
            outcomes.append(body_of(chip))
            assert outcomes[-1] in (old, new), f"write {write}, cell {cell}: {doubtful:#04x}"
        for second in (1, 2, 1 + 7 * write % 15, 14):
            if cut_in(second, left):
                chip.cut_power()
                assert chip.load()[0] == twin.Reading.WHOLE
                assert body_of(chip) in (old, new), f"write {write}, then {second}"
                chip.poke(in_ram)
                assert chip.save()[0] == IDLE
                chip.load()
                assert body_of(chip) == new
        write += 1
    differing = sum(a != b for a, b in zip(record, before[512:], strict=False))
    assert write - 1 == differing + 2  # and the magic, erased and programmed
    assert outcomes.count(new) == 1
    assert len(outcomes) > 3 * differing


def test_a_first_save_can_be_cut_in_any_write(chip, runner_settings_elf):
    """One chip saves into a blank EEPROM; at each write another one starts with what is there."""
    saver = SettingsChip(runner_settings_elf)
    saver.eeprom = slots()
    assert saver.load() == (twin.Reading.NO_RECORD, 0)
    assert not any(saver.set(key, value) for key, value in CHANGES)
    new = body_of(saver)
    record, writes = twin.frame(new, 1), 0
    saver.begin_save()
    while saver.into_write():
        writes += 1
        cell, left = saver.cell_in_work, saver.eeprom
        to_be = twin.ERASED if writes == 1 else record[cell]
        for doubtful in doubtful_values(left[cell], twin.ERASED, to_be):
            chip.eeprom = left[:cell] + bytes([doubtful]) + left[cell + 1 :]
            is_done = cell == 0 and doubtful == twin.MAGIC
            assert chip.load()[0] == (twin.Reading.WHOLE if is_done else twin.Reading.NO_RECORD)
            assert body_of(chip) == (new if is_done else FACTORY)
    assert writes == 1 + len(record.replace(b"\xff", b""))
    assert saver.eeprom == slots(record)


def test_only_cells_that_differ_are_written(chip):
    chip.eeprom = slots(*USED)
    chip.load()
    before = chip.writes
    assert chip.save()[0] == IDLE  # factory's values over factory's, but for the last
    # magic twice, sequence, one value of two bytes, CRC of two
    assert chip.writes - before <= 2 + 1 + 2 + 2
