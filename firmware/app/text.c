/* SPDX-License-Identifier: MIT */
#include "text.h"

#include "version.h"
#include "weight_kf.h"

#include <avr/pgmspace.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* In a form, each of these stands for the next value. */
#define WHOLE "\1"
#define MILLI "\2" /* thousandths, with a point */
#define HEX   "\3"
#define WORDS " (text frames tare clear zero info)"

enum { MILLI_DIGITS = 3 };

static void put(text_line_t *line, char character)
{
    if (line->len < TEXT_LINE_MAX) { line->characters[line->len++] = character; }
}

/* Thousandths need no division: the point is set into the digits. */
static void put_value(text_line_t *line, int32_t value, char how)
{
    const bool is_milli = how == MILLI[0];
    char       digits[12]; /* -2^31 and a terminator */

    if (how == HEX[0]) {
        ultoa((uint32_t)value, digits, 16);
    } else {
        if (value < 0) { put(line, '-'); }
        ultoa(value < 0 ? 0U - (uint32_t)value : (uint32_t)value, digits, 10);
    }
    uint8_t left = (uint8_t)strlen(digits);
    if (is_milli && left <= MILLI_DIGITS) {
        put(line, '0');
        put(line, '.');
        for (uint8_t zeros = left; zeros < MILLI_DIGITS; zeros++) { put(line, '0'); }
    }
    for (const char *digit = digits; left != 0U; left--) {
        put(line, *digit++);
        if (is_milli && left == MILLI_DIGITS + 1U) { put(line, '.'); }
    }
}

/* The form's characters up to its end, values in their places. */
static __attribute__((noinline)) void put_form(text_line_t *line, const char *rom_form,
                                               const int32_t *values)
{
    char character;

    while ((character = (char)pgm_read_byte(rom_form++)) != '\0') {
        if (character <= HEX[0]) {
            put_value(line, *values++, character);
        } else {
            put(line, character);
        }
    }
}

void text_sample(text_line_t *line, const messages_sample_t *sample)
{
    const int32_t half_q7  = 1L << (WEIGHT_KF_FRACTION_BITS - 1);
    const int32_t values[] = {sample->raw_counts, sample->fir_counts,
                              (sample->kf_counts_q7 + half_q7) >> WEIGHT_KF_FRACTION_BITS,
                              sample->net_mg, sample->weight_flags & MESSAGES_WEIGHT_FLAG_STABLE};

    _Static_assert(MESSAGES_WEIGHT_FLAG_STABLE == 1, "shown as 0 or 1");
    line->len = 0;
    put_form(
        line,
        PSTR("raw:" WHOLE ",fir:" WHOLE ",kf:" WHOLE ",weight_g:" MILLI ",stable:" WHOLE "\r\n"),
        values);
}

void text_version(text_line_t *line)
{
    const int32_t values[] = {VERSION_MAJOR, VERSION_MINOR, VERSION_PATCH, (int32_t)VERSION_BUILD};

    line->len = 0;
    put_form(line, PSTR("# Terazi v" WHOLE "." WHOLE "." WHOLE " build=x" HEX WORDS "\r\n"),
             values);
}

void text_converter(text_line_t *line, uint8_t gain, uint32_t rate_hz_q16)
{
    /* Hz in thousandths: rate < 2^8 Hz, so that 24 bits times 1000 / 2^8 stays below 2^32 */
    const int32_t values[] = {gain, (int32_t)(((rate_hz_q16 >> 2) * 1000U) >> 14)};

    line->len = 0;
    put_form(line, PSTR("# gain=" WHOLE " rate_hz=" MILLI "\r\n"), values);
}

/* A switch would be made into a table in RAM. */
static const char *name_of(uint8_t result)
{
    if (result == MESSAGES_RESULT_OK) { return PSTR(": ok\r\n"); }
    if (result == MESSAGES_RESULT_NOT_STABLE) { return PSTR(": not stable\r\n"); }
    if (result == MESSAGES_RESULT_OUT_OF_RANGE) { return PSTR(": out of range\r\n"); }
    if (result == MESSAGES_RESULT_CALIBRATING) { return PSTR(": calibrating\r\n"); }
    return PSTR(": unknown" WORDS "\r\n");
}

void text_answer(text_line_t *line, const char *word, uint8_t result)
{
    line->len = 0;
    put(line, '#');
    put(line, ' ');
    while (*word != '\0') { put(line, *word++); }
    put_form(line, name_of(result), NULL);
}
