/* SPDX-License-Identifier: MIT */
#include "lamp.h"

#include "led.h"

#include <stdbool.h>

/* In 2^16 us, so that a byte of the clock is enough. */
enum {
    BEAT  = 8, /* 0.52 s */
    FLASH = 3, /* 0.20 s lit, as long dark: nine of them can be counted */
    PAUSE = 18 /* 1.18 s */
};

static bool     is_well, is_lit;
static uint8_t  halves;  /* left of this turn: odd ones are lit, 0 is the pause */
static uint8_t  since;   /* when this half began */
static uint8_t  length;  /* how long it is */
static uint16_t unshown; /* faults since this turn began */

void lamp_init(void)
{
    led_init();
    is_well = true;
    is_lit  = true;
    length  = BEAT;
}

void lamp_update(uint16_t faults, uint32_t device_us)
{
    const uint8_t now = (uint8_t)(device_us >> 16);

    unshown |= faults;
    faults = unshown;
    if ((uint8_t)(now - since) < length && !(is_well && faults != 0U)) { return; }
    since   = now;
    length  = FLASH;
    is_well = false;
    if (halves != 0U) {
        if (--halves == 0U) { length = PAUSE; }
    } else if (faults != 0U) { /* a flash for each bit up to the lowest that is set, dark first */
        for (halves = 2; (faults & 1U) == 0U; faults >>= 1) { halves = (uint8_t)(halves + 2U); }
        unshown = 0;
    } else {
        is_well = true;
        length  = BEAT;
    }
    is_lit = is_well ? !is_lit : (halves & 1U) != 0U;
    led_set(is_lit);
}
