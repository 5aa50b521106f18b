/* SPDX-License-Identifier: MIT */
/* settings - what outlives a reset: values by key, and records of them that a power cut at any
 * instant leaves readable.
 *
 * Model     settings_t holds the modules' own configurations, in their only copy; settings.toml
 *           gives every value a key, a range and a factory value. A value travels as i32
 * Record    magic u8 | version u8 | len u8 | sequence u16 | values in the order of their keys, len
 *           bytes | CRC-16/MCRF4XX u16 of all but the magic; little-endian
 * Slots     SETTINGS_SLOTS of SETTINGS_SLOT_LEN bytes each in EEPROM; even ones are the first bank,
 *           odd ones the second. Records go to the slots in turn, so that banks alternate and the
 *           newest whole record is never touched
 * Saving    erases the slot's magic before all, then passes over the record and writes what differs
 *           until a pass finds nothing to write, and nothing was asked for in it: the read-back.
 *           The magic comes after all: at every instant before it holds, the newest record is the
 *           old one, and from then on the new one (notes). A cell that does not take its value
 *           spoils the slot: the next one is tried, but never the newest record's
 * Old, new  a record with fewer values than this firmware knows gives those, the others keep what
 *           they had; one with more, or of another version, is foreign: refused as a whole
 * Bad data  a value beyond its range is refused; a record's were not, when it was written, and no
 *           range ever shrinks. What must hold between values the modules check (scale_init,
 *           checkweigher_init)
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef SETTINGS_H
#define SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

enum {
    SETTINGS_SLOTS    = 4,
    SETTINGS_SLOT_LEN = 256,
    SETTINGS_HEAD_LEN = 5, /* before the values */
    SETTINGS_MAGIC    = 0x54,
    SETTINGS_ERASED   = 0xFF /* what an erased cell reads; anything but the magic would do */
};

/* In settings_table.h, as are the keys and SETTINGS_RECORD_LEN. */
typedef struct settings settings_t;

typedef enum {
    SETTINGS_OK,
    SETTINGS_UNKNOWN_KEY,
    SETTINGS_OUT_OF_RANGE,
    SETTINGS_WRITE_PROTECTED /* written by a calibration or a command only */
} settings_status_t;

/* What the bytes read so far are, in this order. */
typedef enum {
    SETTINGS_READING,   /* the next byte, please */
    SETTINGS_NO_RECORD, /* never written, or its writing was cut */
    SETTINGS_ROTTEN,    /* a record was here, and a bit of it has changed since */
    SETTINGS_FOREIGN,   /* a whole record of a firmware that knows more, or other things */
    SETTINGS_WHOLE
} settings_reading_t;

/* A record on its way in or out, byte by byte. */
typedef struct {
    uint16_t crc;     /* of the bytes so far */
    uint8_t  at;      /* bytes so far */
    uint8_t  key;     /* whose value passes */
    uint8_t  byte;    /* of this value, how many have passed */
    uint8_t  head[4]; /* version, len, sequence */
} settings_record_t;

/* The newest record among the slots. */
typedef struct {
    uint8_t  reading;  /* SETTINGS_WHOLE, SETTINGS_FOREIGN, or none: NO_RECORD */
    uint8_t  slot;     /* where it stands; without one, the last: so the next is 0 */
    uint8_t  rotten;   /* slots; one of them may have held a newer one */
    uint16_t sequence; /* of it; 0 without one */
} settings_choice_t;

/* The step of a save that comes next, as the bits of EECR say it. */
typedef enum {
    SETTINGS_CELL_REPLACE = 0x00, /* write the cell */
    SETTINGS_CELL_ERASE   = 0x10, /* only erase it */
    SETTINGS_CELL_PROGRAM = 0x20, /* only write it: it was erased before */
    SETTINGS_CELL_PASSED  = 0xFF  /* nothing: on to the next */
} settings_cell_t;

typedef enum {
    SETTINGS_SAVE_IDLE,
    SETTINGS_SAVE_WRITING,
    SETTINGS_SAVE_FAILED /* no slot but the newest record's takes what is written */
} settings_save_state_t;

/* A save, cell by cell. */
typedef struct {
    settings_choice_t newest;
    settings_record_t record; /* on its way out */
    uint8_t           state;  /* settings_save_state_t */
    uint8_t           slot;   /* where it goes */
    uint8_t           at;     /* the cell there that comes next */
    uint8_t           wanted; /* what it must hold */
    uint16_t          left;   /* writes that this slot may still take */
    bool              again;  /* another pass: this one wrote something, or a save was asked for */
} settings_save_t;

/* The factory's values; those that a calibration or a command writes only if `calibration`. */
void settings_reset(settings_t *settings, bool calibration);

settings_status_t settings_get(const settings_t *settings, uint8_t key, int32_t *value);

/* If refused, nothing changes. */
settings_status_t settings_set(settings_t *settings, uint8_t key, int32_t value);

/* Before the first byte in either direction; `sequence` is that of the record to be written. */
void settings_record_begin(settings_record_t *record, uint16_t sequence);

/* The next byte of the record of these settings, SETTINGS_RECORD_LEN in all. */
uint8_t settings_record_next(settings_record_t *record, const settings_t *settings);

/* Take the next byte of a slot. Values go to `settings` as they come, so let this be NULL until a
 * first reading has said SETTINGS_WHOLE. After anything but SETTINGS_READING there is no next. */
settings_reading_t settings_record_read(settings_record_t *record, settings_t *settings,
                                        uint8_t byte);

uint16_t settings_record_sequence(const settings_record_t *record);

/* Begin to choose; then tell what each slot's reading ended with. */
void settings_choice_begin(settings_choice_t *choice);
void settings_choose(settings_choice_t *choice, uint8_t slot, const settings_record_t *record,
                     settings_reading_t reading);

/* Idle; `newest` is where the next save must not go. */
void settings_save_begin(settings_save_t *save, const settings_choice_t *newest);

/* Save, or where a save is under way, take in what has changed since. Values that belong together
 * are saved together only if this is called after they changed. */
void settings_save_ask(settings_save_t *save);

/* The cell that comes next, while SETTINGS_SAVE_WRITING. */
uint16_t settings_save_address(const settings_save_t *save);

/* What to do with that cell, which holds `cell` now: pass on, or write `save->wanted` there, and
 * come again when that is done. */
settings_cell_t settings_save_step(settings_save_t *save, const settings_t *settings, uint8_t cell);

#endif
