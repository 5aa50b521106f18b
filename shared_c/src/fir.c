/* SPDX-License-Identifier: MIT */
#include "fir.h"

#include "fixed.h"
#include "port_assert.h"
#include "port_fir.h"

enum { SAMPLE_BYTES = 3 };

_Static_assert(2 * SAMPLE_BYTES * FIR_TAPS_MAX <= 255, "byte offsets into the window are uint8_t");

/* Write a sample at both its places, so that any taps neighbours are in order of age. */
static void window_put(fir_t *fir, uint8_t at, int32_t sample_counts)
{
    const uint8_t  taps   = fir->config->taps;
    const uint32_t offset = (uint32_t)(sample_counts - FIXED_COUNTS_MIN); /* 0..2^24-1 */
    uint8_t       *first  = &fir->window[(uint8_t)(at * SAMPLE_BYTES)];
    uint8_t       *second = first + (uint8_t)(taps * SAMPLE_BYTES);

    first[0] = second[0] = (uint8_t)offset;
    first[1] = second[1] = (uint8_t)(offset >> 8);
    first[2] = second[2] = (uint8_t)(offset >> 16);
}

void fir_init(fir_t *fir, const fir_config_t *config, int32_t first_counts)
{
    PORT_ASSERT(config->taps >= 2U && config->taps <= FIR_TAPS_MAX && config->taps % 2U == 0U);

    fir->config         = config;
    fir->next           = 0U;
    fir->clipped        = 0U;
    const int32_t first = fixed_clamp_counts(first_counts, &fir->clipped);
    for (uint8_t at = 0U; at < config->taps; ++at) { window_put(fir, at, first); }
}

int32_t fir_update(fir_t *fir, int32_t sample_counts)
{
    const fir_config_t *config = fir->config;

    window_put(fir, fir->next, fixed_clamp_counts(sample_counts, &fir->clipped));
    if (++fir->next == config->taps) { fir->next = 0U; }
    /* `next` is now the oldest sample, and taps samples in order of age start there. */
    const uint8_t *oldest = &fir->window[(uint8_t)(fir->next * SAMPLE_BYTES)];
    const int32_t  sum    = port_fir_fold(oldest, config->half_q15, (uint8_t)(config->taps / 2U));

    return fixed_clamp_counts(sum, &fir->clipped); /* |sum| <= 2^24: sum |c| < 2 */
}
