/* SPDX-License-Identifier: MIT */
#include "text.h"

#include "version.h"
#include "weight_kf.h"

#include <avr/pgmspace.h>
#include <stdlib.h>
#include <string.h>

/* Lines are for people, who can wait: gcc would copy these into every caller. */
#define COMPACT __attribute__((noinline, cold))

static const char words[] PROGMEM = " (text frames tare clear zero info)";

COMPACT static void put_char(text_line_t *line, char character)
{
    if (line->len < TEXT_LINE_MAX) { line->characters[line->len++] = character; }
}

COMPACT static void put_rom(text_line_t *line, const char *rom_text)
{
    for (char c = (char)pgm_read_byte(rom_text); c != '\0'; c = (char)pgm_read_byte(++rom_text)) {
        put_char(line, c);
    }
}

COMPACT static void put_text(text_line_t *line, const char *text)
{
    while (*text != '\0') { put_char(line, *text++); }
}

COMPACT static void put_u32(text_line_t *line, uint32_t value, uint8_t radix)
{
    char digits[11]; /* 2^32 - 1 and a terminator */

    put_text(line, ultoa(value, digits, radix));
}

COMPACT static void put_i32(text_line_t *line, int32_t value)
{
    char digits[12]; /* -2^31 and a terminator */

    put_text(line, ltoa(value, digits, 10));
}

/* Thousandths, without a division: the point is set into the digits. */
COMPACT static void put_milli(text_line_t *line, int32_t value_milli)
{
    const uint32_t magnitude = value_milli < 0 ? 0U - (uint32_t)value_milli : (uint32_t)value_milli;
    char           digits[11];

    if (value_milli < 0) { put_char(line, '-'); }
    ultoa(magnitude, digits, 10);
    uint8_t before_point = (uint8_t)strlen(digits);
    if (before_point <= 3U) {
        put_rom(line, PSTR("0."));
        for (uint8_t zeros = before_point; zeros < 3U; zeros++) { put_char(line, '0'); }
        put_text(line, digits);
        return;
    }
    before_point = (uint8_t)(before_point - 3U);
    for (uint8_t i = 0; digits[i] != '\0'; i++) {
        if (i == before_point) { put_char(line, '.'); }
        put_char(line, digits[i]);
    }
}

COMPACT static void put_end(text_line_t *line)
{
    put_rom(line, PSTR("\r\n"));
}

void text_sample(text_line_t *line, const messages_sample_t *sample)
{
    const int32_t half_q7 = 1L << (WEIGHT_KF_FRACTION_BITS - 1);

    line->len = 0;
    put_rom(line, PSTR("raw:"));
    put_i32(line, sample->raw_counts);
    put_rom(line, PSTR(",fir:"));
    put_i32(line, sample->fir_counts);
    put_rom(line, PSTR(",kf:"));
    put_i32(line, (sample->kf_counts_q7 + half_q7) >> WEIGHT_KF_FRACTION_BITS);
    put_rom(line, PSTR(",weight_g:"));
    put_milli(line, sample->net_mg);
    put_rom(line, PSTR(",stable:"));
    put_char(line, (sample->weight_flags & MESSAGES_WEIGHT_FLAG_STABLE) != 0U ? '1' : '0');
    put_end(line);
}

void text_version(text_line_t *line)
{
    line->len = 0;
    put_rom(line, PSTR("# Terazi v"));
    put_u32(line, VERSION_MAJOR, 10);
    put_char(line, '.');
    put_u32(line, VERSION_MINOR, 10);
    put_char(line, '.');
    put_u32(line, VERSION_PATCH, 10);
    put_rom(line, PSTR(" build=x"));
    put_u32(line, VERSION_BUILD, 16);
    put_rom(line, words);
    put_end(line);
}

void text_converter(text_line_t *line, uint8_t gain, uint32_t rate_hz_q16)
{
    /* Hz in thousandths: rate < 2^8 Hz, so that 24 bits times 1000 / 2^8 stays below 2^32 */
    const uint32_t rate_mhz = ((rate_hz_q16 >> 2) * 1000U) >> 14;

    line->len = 0;
    put_rom(line, PSTR("# gain="));
    put_u32(line, gain, 10);
    put_rom(line, PSTR(" rate_hz="));
    put_milli(line, (int32_t)rate_mhz);
    put_end(line);
}

void text_answer(text_line_t *line, const char *word, uint8_t result)
{
    line->len = 0;
    put_rom(line, PSTR("# "));
    put_text(line, word);
    switch (result) {
    case MESSAGES_RESULT_OK: put_rom(line, PSTR(": ok")); break;
    case MESSAGES_RESULT_NOT_STABLE: put_rom(line, PSTR(": not stable")); break;
    case MESSAGES_RESULT_OUT_OF_RANGE: put_rom(line, PSTR(": out of range")); break;
    case MESSAGES_RESULT_CALIBRATING: put_rom(line, PSTR(": calibrating")); break;
    default:
        put_rom(line, PSTR(": unknown"));
        put_rom(line, words);
        break;
    }
    put_end(line);
}
