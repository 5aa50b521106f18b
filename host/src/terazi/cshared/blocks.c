/* SPDX-License-Identifier: MIT */
#include "blocks.h"

#include "mass.h"

void blocks_fir(fir_t *fir, const int32_t samples[], int32_t results[], size_t count)
{
    for (size_t at = 0U; at < count; ++at) { results[at] = fir_update(fir, samples[at]); }
}

void blocks_weight_kf(weight_kf_t *kf, const int32_t measured[], int32_t estimates_q7[],
                      size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        estimates_q7[at] = weight_kf_update(kf, measured[at]);
    }
}

void blocks_mass(const int32_t kf_q7[], int32_t tare_q7, uint32_t span_ug_per_count_q16,
                 int32_t mass_mg[], size_t count)
{
    /* |kf|, |tare| <= 2^30, as weight_kf.h has it and the caller has checked */
    for (size_t at = 0U; at < count; ++at) {
        mass_mg[at] = mass_from_counts(kf_q7[at] - tare_q7, span_ug_per_count_q16);
    }
}

frame_status_t blocks_decode(frame_decoder_t *decoder, const uint8_t bytes[], size_t count,
                             size_t *used)
{
    for (*used = 0U; *used < count;) {
        const frame_status_t status = frame_decoder_push(decoder, bytes[(*used)++]);
        if (status != FRAME_PENDING) { return status; }
    }
    return FRAME_PENDING;
}
