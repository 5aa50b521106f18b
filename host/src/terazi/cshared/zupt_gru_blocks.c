/* SPDX-License-Identifier: MIT */
#include "zupt_gru_blocks.h"

enum { AXES = 3 };

void zupt_gru_blocks(zupt_gru_t *gru, const int16_t gyro_b_counts[], const int16_t acc_b_counts[],
                     uint8_t flags[], size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        flags[at] = zupt_gru_update(gru, &gyro_b_counts[AXES * at], &acc_b_counts[AXES * at]);
    }
}
