/* SPDX-License-Identifier: MIT */
#include "mass.h"

#include <stdbool.h>

#include "port_hot.h"
#include "port_mass.h"

/* Half a milligram, in parts of which a milligram has 2^7 * 2^16 * 1000 = 125 * 2^26. */
#define HALF_PARTS (UINT32_C(125) << 25)

PORT_OUTLINE int32_t mass_from_counts(int32_t net_counts_q7, uint32_t span_ug_per_count_q16)
{
    const bool     negative  = net_counts_q7 < 0;
    const uint32_t magnitude = negative ? 0U - (uint32_t)net_counts_q7 : (uint32_t)net_counts_q7;
    /* One part less for a negative: half up is half towards zero. */
    const uint32_t half   = HALF_PARTS - (negative ? 1U : 0U);
    const uint32_t scaled = port_mass_scale(magnitude, span_ug_per_count_q16, half);

    return negative ? -(int32_t)scaled : (int32_t)scaled; /* <= 2^37 / 125 < 2^31 */
}
