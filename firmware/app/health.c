/* SPDX-License-Identifier: MIT */
#include "health.h"

static uint16_t held, seen, told;

void health_note(uint16_t mask, uint16_t faults)
{
    held = (uint16_t)((held & (uint16_t)~mask) | faults);
    seen |= faults;
}

uint16_t health_faults(void)
{
    return held;
}

uint16_t health_seen(void)
{
    return seen;
}

uint16_t health_take_changed(void)
{
    const uint16_t changed = held ^ told;

    told = held;
    return changed;
}
