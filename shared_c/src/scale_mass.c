/* SPDX-License-Identifier: MIT */
#include "scale.h"

#include "port_hot.h"
#include "port_wide.h"

static PORT_OUTLINE int32_t rail(int32_t value)
{
    return value < 0 ? -SCALE_31_BITS : SCALE_31_BITS - 1;
}

/* Into 31 bits: the upper two differ only beyond. */
static inline int32_t in_31_bits(int32_t value)
{
    const uint8_t top = (uint8_t)((uint32_t)value >> 24);

    return (uint8_t)(top + 0x40U) < 0x80U ? value : rail(value);
}

PORT_OUTLINE int32_t scale_mass(const scale_t *scale, int32_t counts_q7)
{
    const scale_config_t *config = scale->config;
    uint8_t               at     = (uint8_t)(config->points - 1U);
    const int32_t        *point  = &config->point_counts_q7[at];
    const bool            falls  = scale->falling;
    int32_t               past;

    counts_q7 = in_31_bits(counts_q7);
    do {                             /* the last segment whose point was reached, or the first */
        past = counts_q7 - *--point; /* |.| < 2^31 */
        if (falls) { past = -past; }
        --at;
    } while (past < 0 && at != 0U);
    const bool below = past < 0;

    if (below) { past = -past; }
    int32_t rise = (int32_t)port_wide_high((uint32_t)past, scale->slope_q32[at]); /* < 2^31 */
    /* |mass of a point| <= 2^29: so much more reaches 2^30 on either side */
    if (rise > 0x5FFFFFFF) { rise = 0x5FFFFFFF; }
    if (below) { rise = -rise; }
    return in_31_bits(config->point_mass_mg[at] + rise);
}
