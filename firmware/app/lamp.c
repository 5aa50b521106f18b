/* SPDX-License-Identifier: MIT */
#include "lamp.h"

#include "led.h"

#include <stdbool.h>

#define BEAT_US  500000UL
#define FLASH_US 200000UL /* lit as long as dark: nine of them can be counted */
#define PAUSE_US 1200000UL

static bool     is_well, is_lit;
static uint8_t  halves;   /* left of this turn: odd ones are lit, 0 is the pause */
static uint16_t unshown;  /* faults since this turn began */
static uint32_t since_us; /* when this half began */
static uint32_t for_us;   /* how long it is */

void lamp_init(void)
{
    led_init();
    is_well = true;
    is_lit  = true;
    for_us  = BEAT_US;
}

/* A flash for each bit up to the lowest that is set, dark first. */
static uint8_t halves_of(uint16_t faults)
{
    uint8_t found = 0;

    for (; faults != 0U; faults = (uint16_t)(faults << 1)) { found++; }
    return found != 0U ? (uint8_t)(2U * (17U - found)) : 0U;
}

void lamp_update(uint16_t faults, uint32_t device_us)
{
    unshown |= faults;
    if (device_us - since_us < for_us && !(is_well && unshown != 0U)) { return; }
    since_us = device_us;
    if (halves != 0U) {
        halves--;
    } else {
        halves  = halves_of(unshown);
        unshown = 0;
        is_well = halves == 0U;
    }
    is_lit = is_well ? !is_lit : (halves & 1U) != 0U;
    for_us = is_well ? BEAT_US : halves != 0U ? FLASH_US : PAUSE_US;
    led_set(is_lit);
}
