/* SPDX-License-Identifier: MIT */
#include "health.h"

#include "port_reach.h"

typedef struct {
    uint16_t held, seen, told;
} health_t;

static health_t health;

__attribute__((noinline)) void health_note(uint16_t mask, uint16_t faults)
{
    health_t *const it = PORT_REACH(&health);

    it->held = (uint16_t)((it->held & (uint16_t)~mask) | faults);
    it->seen |= faults;
}

__attribute__((noinline)) void health_note_one(uint16_t fault, bool holds)
{
    health_note(fault, holds ? fault : 0U);
}

uint16_t health_faults(void)
{
    return health.held;
}

uint16_t health_seen(void)
{
    return health.seen;
}

uint16_t health_take_changed(void)
{
    const uint16_t changed = health.held ^ health.told;

    health.told = health.held;
    return changed;
}
