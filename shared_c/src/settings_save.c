/* SPDX-License-Identifier: MIT */
#include "settings.h"

#include "port_outline.h"
#include "settings_table.h"

enum { WRITES_MAX = 340 }; /* in one slot: a record, and a third of one for second thoughts */

void settings_save_begin(settings_save_t *save, const settings_choice_t *newest)
{
    *save = (settings_save_t){.newest = *newest, .state = SETTINGS_SAVE_IDLE};
}

static void begin_pass(settings_save_t *save)
{
    uint16_t sequence = (uint16_t)(save->newest.sequence + 1U);

    if (sequence == 0U) { sequence = 1U; } /* 0 says that there is none */
    settings_record_begin(&save->record, sequence);
    save->record.at = 1U; /* the magic comes last */
    save->again     = false;
}

/* The slot behind this one; false where that holds the newest record. */
static bool begin_slot(settings_save_t *save)
{
    save->slot   = (save->slot + 1U) % SETTINGS_SLOTS;
    save->at     = 0U;
    save->wanted = SETTINGS_ERASED;
    save->left   = WRITES_MAX;
    begin_pass(save);
    return save->slot != save->newest.slot;
}

static void begin(settings_save_t *save)
{
    save->state = SETTINGS_SAVE_WRITING;
    save->slot  = save->newest.slot;
    begin_slot(save); /* there are slots enough */
}

void settings_save_ask(settings_save_t *save)
{
    save->again = true;
    if (save->state != SETTINGS_SAVE_WRITING) { begin(save); }
}

uint16_t settings_save_address(const settings_save_t *save)
{
    _Static_assert(SETTINGS_SLOT_LEN == 1 << 8, "a slot's number is an address's upper byte");
    return (uint16_t)((uint16_t)save->slot << 8 | save->at);
}

static void finish(settings_save_t *save)
{
    save->newest.slot     = save->slot;
    save->newest.sequence = settings_record_sequence(&save->record);
    save->state           = SETTINGS_SAVE_IDLE;
    if (save->again) { begin(save); } /* asked for since the last pass */
}

/* The cell holds what it must: on to the next. */
static void advance(settings_save_t *save, const settings_t *settings)
{
    if (save->at == 0U && save->wanted == SETTINGS_MAGIC) {
        finish(save);
        return;
    }
    if (++save->at == SETTINGS_RECORD_LEN) {
        if (!save->again) {
            save->at     = 0U;
            save->wanted = SETTINGS_MAGIC;
            return;
        }
        save->at = 1U;
        begin_pass(save);
    }
    save->wanted = settings_record_next(&save->record, settings);
}

PORT_OUTLINE settings_cell_t settings_save_step(settings_save_t *save, const settings_t *settings,
                                                uint8_t cell)
{
    const bool is_magic = save->at == 0U;
    const bool erases   = is_magic && save->wanted == SETTINGS_ERASED;

    /* The magic is erased in every save, whatever it reads, so that it need only be programmed. */
    if (cell == save->wanted && !(erases && save->left == WRITES_MAX)) {
        advance(save, settings);
        return SETTINGS_CELL_PASSED;
    }
    if (save->left == 0U) {
        if (!begin_slot(save)) { save->state = SETTINGS_SAVE_FAILED; }
        return SETTINGS_CELL_PASSED;
    }
    save->left--;
    if (erases) { return SETTINGS_CELL_ERASE; }
    if (is_magic) { return SETTINGS_CELL_PROGRAM; }
    save->again = true;
    return SETTINGS_CELL_REPLACE;
}
