/* SPDX-License-Identifier: MIT */
/* runner_settings - serves settings, with the firmware's own store and EEPROM driver behind it, in
 * an image of their own. */
#include "runner.h"

#include "messages.h"
#include "settings_table.h"
#include "store.h"

#include <string.h>

enum {
    ASK_LOAD   = 'l', /* -> reading u8, sequence u16 */
    ASK_GET    = 'g', /* key u8 -> status u8, value i32 */
    ASK_SET    = 's', /* key u8, value i32 -> status u8 */
    ASK_RESET  = 'r', /* calibration u8 -> 0 */
    ASK_RECORD = 'p', /* sequence u16 -> the record */
    ASK_SAVE   = 'S'  /* -> state u8, sequence u16, when that is done */
};

static settings_t        settings;
static settings_record_t record;

static uint8_t put_sequence(uint8_t buffer[], uint8_t answer)
{
    const uint16_t sequence = store_sequence();

    buffer[0] = answer;
    memcpy(&buffer[1], &sequence, sizeof sequence);
    return 3;
}

static uint8_t get(uint8_t buffer[])
{
    int32_t value = 0;

    buffer[0] = (uint8_t)settings_get(&settings, buffer[0], &value);
    memcpy(&buffer[1], &value, sizeof value);
    return 5;
}

static uint8_t set(uint8_t buffer[])
{
    int32_t value;

    memcpy(&value, &buffer[1], sizeof value);
    buffer[0] = (uint8_t)settings_set(&settings, buffer[0], value);
    return 1;
}

static uint8_t put_record(uint8_t buffer[])
{
    uint16_t sequence;

    memcpy(&sequence, buffer, sizeof sequence);
    settings_record_begin(&record, sequence);
    for (uint8_t at = 0; at < SETTINGS_RECORD_LEN; at++) {
        buffer[at] = settings_record_next(&record, &settings);
    }
    return SETTINGS_RECORD_LEN;
}

static uint8_t save(uint8_t buffer[])
{
    store_save();
    do {
        store_tick(&settings);
    } while (store_state() == MESSAGES_SETTINGS_STATE_WRITING);
    return put_sequence(buffer, store_state());
}

uint8_t runner_serve(uint8_t op, uint8_t buffer[], uint8_t len)
{
    (void)len;
    switch (op) {
    case ASK_LOAD: return put_sequence(buffer, (uint8_t)store_load(&settings));
    case ASK_GET: return get(buffer);
    case ASK_SET: return set(buffer);
    case ASK_RESET: settings_reset(&settings, buffer[0] != 0U); return 1;
    case ASK_RECORD: return put_record(buffer);
    case ASK_SAVE: return save(buffer);
    default: return 0;
    }
}
