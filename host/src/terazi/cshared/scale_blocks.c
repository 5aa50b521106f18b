/* SPDX-License-Identifier: MIT */
#include "scale_blocks.h"

void scale_blocks_update(scale_t *scale, const int32_t counts_q7[], const uint32_t device_us[],
                         uint8_t flags[], int32_t net_mg[], int32_t shown[], size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        flags[at]  = scale_update(scale, counts_q7[at], device_us[at]);
        net_mg[at] = scale->net_mg;
        shown[at]  = scale_shown(scale);
    }
}
