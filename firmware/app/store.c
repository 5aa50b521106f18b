/* SPDX-License-Identifier: MIT */
#include "store.h"

#include "eeprom.h"
#include "idle.h"
#include "messages.h"

#include <stddef.h>

_Static_assert((int)SETTINGS_SAVE_IDLE == (int)MESSAGES_SETTINGS_STATE_IDLE &&
                   (int)SETTINGS_SAVE_WRITING == (int)MESSAGES_SETTINGS_STATE_WRITING &&
                   (int)SETTINGS_SAVE_FAILED == (int)MESSAGES_SETTINGS_STATE_FAILED,
               "STATUS tells the state as it is");
_Static_assert((int)SETTINGS_CELL_REPLACE == (int)EEPROM_REPLACE &&
                   (int)SETTINGS_CELL_ERASE == (int)EEPROM_ERASE &&
                   (int)SETTINGS_CELL_PROGRAM == (int)EEPROM_PROGRAM,
               "a step is a bit of EECR");

enum { CELLS_A_TICK = 16 };

static settings_save_t save;

static settings_reading_t read_slot(settings_record_t *record, uint8_t slot, settings_t *settings)
{
    settings_reading_t reading = SETTINGS_READING;

    settings_record_begin(record, 0);
    for (uint8_t at = 0; reading == SETTINGS_READING; at++) { /* 256 bytes end every record */
        const uint16_t address = (uint16_t)((uint16_t)slot << 8 | at);
        reading                = settings_record_read(record, settings, eeprom_read(address));
    }
    return reading;
}

settings_reading_t store_load(settings_t *settings)
{
    settings_choice_t newest;
    settings_record_t record;

    settings_reset(settings, true);
    settings_choice_begin(&newest);
    for (uint8_t slot = 0; slot < SETTINGS_SLOTS; slot++) {
        const settings_reading_t reading = read_slot(&record, slot, NULL);
        settings_choose(&newest, slot, &record, reading);
    }
    if (newest.reading == SETTINGS_WHOLE) { read_slot(&record, newest.slot, settings); }
    settings_save_begin(&save, &newest);
    return newest.rotten != 0U ? SETTINGS_ROTTEN : newest.reading;
}

void store_save(void)
{
    settings_save_ask(&save);
}

void store_tick(const settings_t *settings)
{
    if (save.state != SETTINGS_SAVE_WRITING) { return; }
    idle_post_work(); /* come again at once */
    for (uint8_t left = CELLS_A_TICK; left != 0U && !eeprom_is_busy(); left--) {
        const uint16_t        address = settings_save_address(&save);
        const settings_cell_t step    = settings_save_step(&save, settings, eeprom_read(address));

        if (step != SETTINGS_CELL_PASSED) { eeprom_write(address, save.wanted, (uint8_t)step); }
        if (save.state != SETTINGS_SAVE_WRITING) { return; }
    }
}

uint8_t store_state(void)
{
    return save.state;
}

uint16_t store_sequence(void)
{
    return save.newest.sequence;
}
