/* SPDX-License-Identifier: MIT */
#include "settings.h"

#include "port_crc.h"
#include "port_outline.h"
#include "port_rom.h"
#include "settings_table.h"

#include <stddef.h>
#include <string.h>

enum { PAYLOAD_MAX = SETTINGS_SLOT_LEN - SETTINGS_HEAD_LEN - 2, LEN_AT = 2 };

_Static_assert((int)SETTINGS_PAYLOAD_LEN <= (int)PAYLOAD_MAX, "a record fits in a slot");

/* Which byte of a value in memory is its byte `at` from the lowest: folds to `at` on this chip. */
static uint8_t ordered(uint8_t at, uint8_t width)
{
    const uint16_t one = 1U;
    uint8_t        first;

    memcpy(&first, &one, 1);
    return first == 1U ? at : (uint8_t)(width - 1U - at);
}

/* What the tables say of a key. */
typedef struct {
    port_place_t place;  /* of the value, in settings_t */
    uint8_t      limits; /* where its limits stand, and whether it is protected */
    uint8_t      width;  /* 1, 2 or 4 bytes */
} entry_t;

static PORT_OUTLINE entry_t entry_of(uint8_t key)
{
    const settings_entry_t *row    = &settings_table[key];
    const uint8_t           limits = port_rom_u8(&row->limits);
    const uint8_t           which  = limits & (uint8_t)~SETTINGS_PROTECTED;
    uint8_t                 width  = 1U;

    if (which >= SETTINGS_LIMITS_16) { width = 2U; }
    if (which >= SETTINGS_LIMITS_32) { width = 4U; }
    return (entry_t){port_rom_place(&row->place), limits, width};
}

settings_status_t settings_get(const settings_t *settings, uint8_t key, int32_t *value)
{
    if (key >= SETTINGS_KEYS) { return SETTINGS_UNKNOWN_KEY; }
    const entry_t  entry = entry_of(key);
    const uint8_t *bytes = (const uint8_t *)settings + entry.place;
    const uint8_t  which = entry.limits & (uint8_t)~SETTINGS_PROTECTED;
    const uint8_t  least = port_rom_u8(&settings_limits[which]);
    const bool below = (least & bytes[ordered((uint8_t)(entry.width - 1U), entry.width)]) >= 0x80U;
    uint32_t   found = below ? UINT32_MAX : 0U;

    for (uint8_t at = entry.width; at != 0U;) {
        found = found << 8 | bytes[ordered(--at, entry.width)];
    }
    *value = (int32_t)found;
    return SETTINGS_OK;
}

settings_status_t settings_set(settings_t *settings, uint8_t key, int32_t value)
{
    if (key >= SETTINGS_KEYS) { return SETTINGS_UNKNOWN_KEY; }
    const entry_t entry = entry_of(key);
    if (entry.limits >= SETTINGS_PROTECTED) { return SETTINGS_WRITE_PROTECTED; }
    const uint8_t *limits = &settings_limits[entry.limits];
    uint8_t       *bytes  = (uint8_t *)settings + entry.place;
    uint32_t       most   = 0U;

    for (uint8_t at = entry.width; at != 0U; --at) { most = most << 8 | port_rom_u8(&limits[at]); }
    uint8_t  least = port_rom_u8(limits);
    uint32_t size  = (uint32_t)value; /* a negative one is beyond all there is, unless mirrored */
    if (least == SETTINGS_MIRRORED) {
        least = 0U;
        if (value < 0) { size = 0U - size; }
    }
    if (size < least || size > most) { return SETTINGS_OUT_OF_RANGE; }
    for (uint8_t at = 0U; at != entry.width; ++at) {
        bytes[ordered(at, entry.width)] = (uint8_t)value;
        value >>= 8;
    }
    return SETTINGS_OK;
}

void settings_reset(settings_t *settings, bool calibration)
{
    const uint8_t *given = settings_factory;

    for (uint8_t key = 0U; key < SETTINGS_KEYS; ++key) {
        const entry_t entry     = entry_of(key);
        const bool    is_zero   = port_rom_u8(given) != key;
        const bool    is_spared = /* where the calibration is; the IMU's keys are the last */
            entry.limits >= SETTINGS_PROTECTED || key >= SETTINGS_KEY_ACC_XX_Q16;

        if (!is_zero) { ++given; }
        for (uint8_t at = 0U; at < entry.width; ++at) {
            const uint8_t byte = is_zero ? 0U : port_rom_u8(given++);

            if (calibration || !is_spared) {
                ((uint8_t *)settings)[entry.place + ordered(at, entry.width)] = byte;
            }
        }
    }
}

void settings_record_begin(settings_record_t *record, uint16_t sequence)
{
    memset(record, 0, sizeof *record);
    record->crc     = PORT_CRC16_START;
    record->head[0] = SETTINGS_VERSION;
    record->head[1] = SETTINGS_PAYLOAD_LEN;
    record->head[2] = (uint8_t)sequence;
    record->head[3] = (uint8_t)(sequence >> 8);
}

/* Where the next byte of the values stands in settings_t; there must be one. */
static port_place_t next_place(settings_record_t *record)
{
    const entry_t      entry = entry_of(record->key);
    const port_place_t place = (port_place_t)(entry.place + ordered(record->byte, entry.width));

    if (++record->byte == entry.width) {
        record->byte = 0U;
        record->key++;
    }
    return place;
}

uint8_t settings_record_next(settings_record_t *record, const settings_t *settings)
{
    const uint8_t at   = record->at++;
    uint8_t       byte = (uint8_t)record->crc; /* behind it comes its upper half, by its own rule */

    if (at == 0U) { return SETTINGS_MAGIC; }
    if (at < SETTINGS_HEAD_LEN) {
        byte = record->head[at - 1U];
    } else if (at < SETTINGS_HEAD_LEN + SETTINGS_PAYLOAD_LEN) {
        byte = ((const uint8_t *)settings)[next_place(record)];
    }
    record->crc = port_crc16(record->crc, byte);
    return byte;
}

settings_reading_t settings_record_read(settings_record_t *record, settings_t *settings,
                                        uint8_t byte)
{
    const uint8_t at  = record->at++;
    const uint8_t len = record->head[1];

    if (at == 0U) { return byte == SETTINGS_MAGIC ? SETTINGS_READING : SETTINGS_NO_RECORD; }
    record->crc = port_crc16(record->crc, byte);
    if (at < SETTINGS_HEAD_LEN) {
        record->head[at - 1U] = byte;
        return at == LEN_AT && byte > PAYLOAD_MAX ? SETTINGS_ROTTEN : SETTINGS_READING;
    }
    const uint8_t passed = (uint8_t)(at - SETTINGS_HEAD_LEN);
    if (passed < len) {
        if (settings != NULL) { ((uint8_t *)settings)[next_place(record)] = byte; }
        return SETTINGS_READING;
    }
    if (passed == len) { return SETTINGS_READING; }
    if (record->crc != 0U) { return SETTINGS_ROTTEN; } /* a CRC over itself is 0 */
    return record->head[0] == SETTINGS_VERSION && len <= SETTINGS_PAYLOAD_LEN ? SETTINGS_WHOLE
                                                                              : SETTINGS_FOREIGN;
}

uint16_t settings_record_sequence(const settings_record_t *record)
{
    return (uint16_t)((uint16_t)record->head[3] << 8 | record->head[2]);
}

void settings_choice_begin(settings_choice_t *choice)
{
    *choice = (settings_choice_t){.reading = SETTINGS_NO_RECORD, .slot = SETTINGS_SLOTS - 1};
}

void settings_choose(settings_choice_t *choice, uint8_t slot, const settings_record_t *record,
                     settings_reading_t reading)
{
    const uint16_t sequence = settings_record_sequence(record);

    if (reading == SETTINGS_ROTTEN) { choice->rotten++; }
    if (reading < SETTINGS_FOREIGN) { return; }
    /* The count of records wraps: ahead by less than half of it is newer. */
    if (choice->reading != SETTINGS_NO_RECORD &&
        (uint16_t)(sequence - choice->sequence) >= 0x8000U) {
        return;
    }
    choice->reading  = reading;
    choice->slot     = slot;
    choice->sequence = sequence;
}
