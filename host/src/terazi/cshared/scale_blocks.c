/* SPDX-License-Identifier: MIT */
#include "scale_blocks.h"

void scale_blocks_update(scale_t *scale, const int32_t raw_q7[], const int32_t counts_q7[],
                         const uint32_t device_us[], uint8_t flags[], int32_t net_mg[],
                         int32_t shown[], size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        const int32_t raw = raw_q7 == NULL ? counts_q7[at] : raw_q7[at];
        flags[at]         = scale_update(scale, counts_q7[at], raw, device_us[at]);
        net_mg[at]        = scale->net_mg;
        shown[at]         = scale_shown(scale);
    }
}

void scale_blocks_mass(const scale_t *scale, const int32_t counts_q7[], int32_t mass_mg[],
                       size_t count)
{
    for (size_t at = 0U; at < count; ++at) { mass_mg[at] = scale_mass(scale, counts_q7[at]); }
}

void scale_blocks_checkweigher(checkweigher_t *checkweigher, const int32_t mass_mg[],
                               const uint32_t device_us[], uint8_t events[], int32_t weighed_mg[],
                               size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        events[at]     = (uint8_t)checkweigher_update(checkweigher, mass_mg[at], device_us[at]);
        weighed_mg[at] = checkweigher->mass_mg;
    }
}
