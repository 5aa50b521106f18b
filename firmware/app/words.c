/* SPDX-License-Identifier: MIT */
#include "words.h"

#include "command.h"
#include "messages.h"
#include "telemetry.h"

#include <avr/pgmspace.h>
#include <string.h>

enum {
    WORD_MAX    = 7,   /* characters of the longest line that is taken */
    LINE_BROKEN = 0xFF /* too long or not printable: nothing until its end */
};

typedef struct {
    char    word[WORD_MAX];
    uint8_t id;
    uint8_t payload; /* of SET_TEXT_MODE */
} entry_t;

static const entry_t entries[] PROGMEM = {
    {"text", MESSAGES_SET_TEXT_MODE_ID, 1}, {"frames", MESSAGES_SET_TEXT_MODE_ID, 0},
    {"tare", MESSAGES_TARE_ID, 0},          {"clear", MESSAGES_TARE_CLEAR_ID, 0},
    {"zero", MESSAGES_ZERO_ID, 0},          {"info", MESSAGES_GET_INFO_ID, 0},
};

static char    word[WORD_MAX + 1];
static uint8_t word_len; /* 0..WORD_MAX, or LINE_BROKEN */
static bool    after_return;

void words_init(void)
{
    word_len     = 0;
    after_return = false;
}

/* The word's command, 0 if it is none. */
static uint8_t look_up(uint8_t *payload)
{
    const entry_t *entry = entries;

    for (uint8_t left = sizeof entries / sizeof entries[0]; left != 0U; left--) {
        if (strcmp_P(word, entry->word) == 0) {
            *payload = pgm_read_byte(&entry->payload);
            return pgm_read_byte(&entry->id);
        }
        entry++;
    }
    return 0;
}

static void run_word(void)
{
    uint8_t       on = 0;
    const uint8_t id = look_up(&on);

    const uint8_t result = command_run(id, on);

    if (id == 0U) { telemetry_count_bad_rx(); }
    if (!telemetry_text_mode()) {
        if (id != 0U) { command_acknowledge(id, 0, result); }
    } else if (id == MESSAGES_GET_INFO_ID) {
        telemetry_info_lines();
    } else {
        telemetry_answer_line(word, result);
    }
}

bool words_receive(uint8_t byte)
{
    const bool is_return   = byte == '\r';
    const bool is_line_end = is_return || byte == '\n';
    const bool second_half = byte == '\n' && after_return; /* of \r\n */

    after_return = false;
    if (byte == 0U) {
        word_len = 0;
    } else if (!is_line_end) {
        const bool fits = word_len < WORD_MAX && byte >= ' ' && byte <= '~';
        if (fits) {
            word[word_len++] = (char)byte;
        } else {
            word_len = LINE_BROKEN;
        }
    } else if (word_len != 0U && word_len != LINE_BROKEN) {
        word[word_len] = '\0';
        word_len       = 0;
        after_return   = is_return;
        run_word();
        return true;
    } else {
        word_len = 0;
    }
    return second_half;
}
