/* SPDX-License-Identifier: MIT */
#include "setup.h"

#include "attitude.h"
#include "health.h"
#include "messages.h"
#include "store.h"
#include "weighing.h"

settings_t setup;

static void note_lost(bool is_lost)
{
    health_note_one(MESSAGES_FAULT_FLAG_SETTINGS_LOST, is_lost);
}

void setup_init(void)
{
    const settings_reading_t reading = store_load(&setup);
    bool                     is_lost = reading == SETTINGS_ROTTEN || reading == SETTINGS_FOREIGN;

    if (!weighing_setup(false) || !attitude_setup()) {
        settings_reset(&setup, true);
        weighing_setup(false);
        attitude_setup();
        is_lost = true;
    }
    note_lost(is_lost);
}

uint8_t setup_get(uint8_t key, int32_t *value)
{
    const settings_status_t status = settings_get(&setup, key, value);

    return status == SETTINGS_OK ? MESSAGES_RESULT_OK : MESSAGES_RESULT_NOTHING_THERE;
}

uint8_t setup_set(uint8_t key, int32_t value)
{
    int32_t before;

    if (settings_get(&setup, key, &before) != SETTINGS_OK) { return MESSAGES_RESULT_NOTHING_THERE; }
    switch (settings_set(&setup, key, value)) {
    case SETTINGS_OK: break;
    case SETTINGS_WRITE_PROTECTED: return MESSAGES_RESULT_WRITE_PROTECTED;
    case SETTINGS_OUT_OF_RANGE:
    case SETTINGS_UNKNOWN_KEY:
    default: return MESSAGES_RESULT_OUT_OF_RANGE;
    }
    if (value == before) { return MESSAGES_RESULT_OK; }
    if (key < SETTINGS_KEY_IMU_MODE ? weighing_setup_key(key) : attitude_setup_key(key)) {
        return MESSAGES_RESULT_OK;
    }
    settings_set(&setup, key, before);
    return MESSAGES_RESULT_CONTRADICTS;
}

void setup_reset(uint8_t what)
{
    settings_reset(&setup, what == MESSAGES_RESET_WHAT_EVERYTHING);
    weighing_setup(true);
    attitude_setup();
    setup_save();
}

void setup_save(void)
{
    store_save();
    note_lost(false);
}
