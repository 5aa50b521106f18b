/* SPDX-License-Identifier: MIT */
#include "text.h"

#include "port_clamp.h"
#include "port_outline.h"
#include "port_wide.h"
#include "uart.h"
#include "version.h"

#include <avr/pgmspace.h>
#include <stdbool.h>
#include <stddef.h>

/* In a form, each of these stands for the next value. */
#define WHOLE "\1"
#define Q7    "\2" /* rounded half up */
#define MILLI "\3" /* thousandths, with a point */

/* Numbers that are known to the preprocessor cost no code. */
#define QUOTED(name) #name
#define TEXT(number) QUOTED(number)
#define VERSION      TEXT(VERSION_MAJOR) "." TEXT(VERSION_MINOR) "." TEXT(VERSION_PATCH)

enum { MILLI_DECIMALS = 3, DIGITS_MAX = 10 };

static const uint32_t powers[DIGITS_MAX] PROGMEM = {
    1000000000UL, 100000000UL, 10000000UL, 1000000UL, 100000UL, 10000UL, 1000UL, 100UL, 10UL, 1UL,
};

static const char words[] PROGMEM = " (text frames tare clear zero info)\r\n";

static PORT_OUTLINE void put(char character)
{
    uart_put((uint8_t)character);
}

static void put_number(int32_t value, uint8_t decimals)
{
    const uint32_t *rom_power = powers;
    bool            begun     = false;

    if (value < 0) { put('-'); }
    uint32_t rest = value < 0 ? 0U - (uint32_t)value : (uint32_t)value;
    for (uint8_t left = DIGITS_MAX; left-- != 0U;) {
        const uint32_t power = pgm_read_dword(rom_power++);
        char           digit = '0';
        for (; rest >= power; rest -= power) { digit++; }
        if (digit != '0' || left <= decimals) { begun = true; }
        if (begun) { put(digit); }
        if (left == decimals && left != 0U) { put('.'); }
    }
}

/* The form's characters up to its end, values in their places. */
static PORT_OUTLINE void put_form(const char *rom_form, const int32_t *values)
{
    char character;

    while ((character = (char)pgm_read_byte(rom_form++)) != '\0') {
        if (character > MILLI[0]) {
            put(character);
            continue;
        }
        int32_t value = *values++;
        if (character == Q7[0]) { value = port_from_q7(value); }
        put_number(value, character == MILLI[0] ? MILLI_DECIMALS : 0U);
    }
}

_Static_assert(offsetof(messages_sample_t, net_mg) - offsetof(messages_sample_t, raw_counts) ==
                       3 * sizeof(int32_t) &&
                   MESSAGES_WEIGHT_FLAG_STABLE == 1,
               "values in the order of the wire; a flag shown as 0 or 1");

void text_sample(const messages_sample_t *sample)
{
    put_form(PSTR("raw:" WHOLE ",fir:" WHOLE ",kf:" Q7 ",weight_g:" MILLI ",stable:"),
             &sample->raw_counts);
    put((char)('0' + (sample->weight_flags & MESSAGES_WEIGHT_FLAG_STABLE)));
    put_form(PSTR("\r\n"), NULL);
}

void text_version(void)
{
    put_form(PSTR("# Terazi v" VERSION " build=" TEXT(VERSION_BUILD)), NULL);
    put_form(words, NULL);
}

void text_converter(uint8_t gain, uint32_t rate_hz_q16)
{
    /* Hz in thousandths: rate * 1000 / 2^16 */
    const int32_t values[] = {gain, (int32_t)port_wide_high(rate_hz_q16, 1000UL << 16)};

    put_form(PSTR("# gain=" WHOLE " rate_hz=" MILLI "\r\n"), values);
}

/* What is left to put of a result. A switch would be made into a table in RAM. */
static const char *rest_of(uint8_t result)
{
    if (result == MESSAGES_RESULT_OK) { return PSTR(": ok\r\n"); }
    if (result == MESSAGES_RESULT_NOT_STABLE) { return PSTR(": not stable\r\n"); }
    if (result == MESSAGES_RESULT_OUT_OF_RANGE) { return PSTR(": out of range\r\n"); }
    if (result == MESSAGES_RESULT_CALIBRATING) { return PSTR(": calibrating\r\n"); }
    put_form(PSTR(": unknown"), NULL);
    return words;
}

void text_answer(const char *word, uint8_t result)
{
    put_form(PSTR("# "), NULL);
    while (*word != '\0') { put(*word++); }
    put_form(rest_of(result), NULL);
}
