/* SPDX-License-Identifier: MIT */
/* port_clamp - what every filter does to what it is fed. Plain: as src/port_clamp.h says it. */
#include "port_clamp.h"

#include "fixed.h"

void port_count(uint16_t *counter)
{
    if (*counter != UINT16_MAX) { ++*counter; }
}

int32_t port_clamp_counts(int32_t value, uint16_t *clipped)
{
    if (fixed_is_counts(value)) { return value; }
    port_count(clipped);
    return value < 0 ? FIXED_COUNTS_MIN : FIXED_COUNTS_MAX;
}

int32_t port_to_q7(int32_t value)
{
    return (int32_t)((uint32_t)value << 7);
}

int32_t port_from_q7(int32_t value_q7)
{
    return (value_q7 + 64) >> 7;
}
