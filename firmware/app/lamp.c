/* SPDX-License-Identifier: MIT */
#include "lamp.h"

#include "led.h"
#include "port_reach.h"

#include <stdbool.h>

/* In 2^16 us, so that a byte of the clock is enough. */
enum {
    BEAT  = 8, /* 0.52 s */
    FLASH = 3, /* 0.20 s lit, as long dark: nine of them can be counted */
    PAUSE = 18 /* 1.18 s */
};

typedef struct {
    bool     is_well;
    uint8_t  half;    /* odd ones are lit; of a turn those left, 0 is the pause */
    uint8_t  since;   /* when this half began */
    uint8_t  length;  /* how long it is */
    uint16_t unshown; /* faults since this turn began */
} lamp_t;

static lamp_t lamp;

void lamp_init(void)
{
    lamp_t *const it = PORT_REACH(&lamp);

    led_init();
    it->is_well = true;
    it->half    = 1;
    it->length  = BEAT;
}

void lamp_update(uint16_t faults, uint32_t device_us)
{
    lamp_t *const it  = PORT_REACH(&lamp);
    const uint8_t now = (uint8_t)(device_us >> 16);

    it->unshown |= faults;
    faults = it->unshown;
    if ((uint8_t)(now - it->since) < it->length && !(it->is_well && faults != 0U)) { return; }
    uint8_t half = it->half, length = FLASH;

    if (!it->is_well && half != 0U) {
        if (--half == 0U) { length = PAUSE; }
    } else if (faults != 0U) { /* a flash for each bit up to the lowest that is set, dark first */
        for (half = 2; (faults & 1U) == 0U; faults >>= 1) { half = (uint8_t)(half + 2U); }
        it->unshown = 0;
        it->is_well = false;
    } else {
        it->is_well = true;
        half ^= 1U;
        length = BEAT;
    }
    it->half   = half;
    it->since  = now;
    it->length = length;
    led_set((half & 1U) != 0U);
}
