/* SPDX-License-Identifier: MIT */
#include "adaptive_blocks.h"

void adaptive_blocks_kf(weight_kf_adaptive_t *kf, const int32_t measured[], int32_t estimates_q7[],
                        uint32_t noise_q16[], size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        estimates_q7[at] = weight_kf_adaptive_update(kf, measured[at]);
        noise_q16[at]    = kf->noise_q16;
    }
}

void adaptive_blocks_pair(weight_kf_adaptive_pair_t *pair, const int32_t measured[],
                          int32_t estimates_q7[], uint32_t noise_q16[], size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        estimates_q7[at] = weight_kf_adaptive_pair_update(pair, measured[at]);
        noise_q16[at]    = pair->rest.noise_q16;
    }
}
