/* SPDX-License-Identifier: MIT */
#include "port_curve.h"

#include "port_wide.h"

static int32_t in_31_bits(int32_t value)
{
    if (value >= SCALE_31_BITS) { return SCALE_31_BITS - 1; }
    return value < -SCALE_31_BITS ? -SCALE_31_BITS : value;
}

int32_t port_curve(const scale_t *scale, int32_t counts_q7)
{
    const scale_config_t *config = scale->config;
    uint8_t               at     = (uint8_t)(config->points - 1U);
    int32_t               past;

    counts_q7 = in_31_bits(counts_q7);
    do {
        --at;
        past = counts_q7 - config->point_counts_q7[at];
        if (scale->falling) { past = -past; }
    } while (past < 0 && at != 0U);
    const bool below = past < 0;

    if (below) { past = -past; }
    int32_t rise = (int32_t)port_wide_high((uint32_t)past, scale->slope_q32[at]);
    if (rise > 0x5FFFFFFF) { rise = 0x5FFFFFFF; }
    if (below) { rise = -rise; }
    return in_31_bits(config->point_mass_mg[at] + rise);
}
