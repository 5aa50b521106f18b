/* SPDX-License-Identifier: MIT */
#include "fir.h"

#include "fir_designs.h"
#include "fixed.h"
#include "port_assert.h"
#include "port_fir.h"
#include "port_hot.h"

enum { HALF_UNITY_Q15 = 16384, UNITY_Q15 = 32768 };

_Static_assert(FIR_SAMPLE_BYTES *FIR_TAPS_MAX <= 255, "byte offsets into the window are uint8_t");
_Static_assert(2 * FIR_HALF_MAX == FIR_TAPS_MAX, "the longest design's half");

bool fir_load(fir_config_t *config, const int16_t half_q15[], uint8_t taps)
{
    if (taps < 2U || taps > FIR_TAPS_MAX) { return false; }
    int32_t sum       = 0; /* |.| <= 64 * 2^15 = 2^21 */
    int32_t magnitude = 0;
    for (uint8_t k = 0U; 2U * k < taps; ++k) {
        const int32_t tap      = half_q15[k];
        const bool    is_alone = 2U * k + 1U == taps; /* the middle one has no mirror image */
        const int32_t both     = is_alone ? tap : 2 * tap;

        sum += both;
        magnitude += both < 0 ? -both : both;
    }
    if (sum != UNITY_Q15 || magnitude >= 2L * UNITY_Q15) { return false; }
    *config = (fir_config_t){.half_q15 = half_q15, .taps = taps, .loaded = true};
    return true;
}

/* Write a sample at its place, and for the default design once more behind all of them: any taps
 * neighbours are then in order of age, which its straight code needs. */
static void window_put(fir_t *fir, uint8_t at, uint8_t size, int32_t sample_counts)
{
    const uint32_t offset = (uint32_t)(sample_counts - FIXED_COUNTS_MIN); /* 0..2^24-1 */
    uint8_t       *place  = &fir->window[at];

    place[0] = (uint8_t)offset;
    place[1] = (uint8_t)(offset >> 8);
    place[2] = (uint8_t)(offset >> 16);
    if (fir->config != fir_designs[0]) { return; }
    place += size;
    place[0] = (uint8_t)offset;
    place[1] = (uint8_t)(offset >> 8);
    place[2] = (uint8_t)(offset >> 16);
}

static uint8_t window_size(const fir_config_t *config)
{
    return (uint8_t)(FIR_SAMPLE_BYTES * config->taps); /* <= 192 */
}

void fir_init(fir_t *fir, const fir_config_t *config, int32_t first_counts)
{
    PORT_ASSERT(config->taps >= 2U && config->taps <= FIR_TAPS_MAX);

    fir->config         = config;
    fir->next           = 0U;
    fir->clipped        = 0U;
    const uint8_t size  = window_size(config);
    const int32_t first = fixed_clamp_counts(first_counts, &fir->clipped);
    for (uint8_t at = 0U; at < size; at = (uint8_t)(at + FIR_SAMPLE_BYTES)) {
        window_put(fir, at, size, first);
    }
}

/* The sample into the window in place of the oldest; `next` is then where the oldest one is. */
static void take(fir_t *fir, int32_t sample_counts)
{
    const uint8_t size = window_size(fir->config);
    uint8_t       next = fir->next;

    window_put(fir, next, size, fixed_clamp_counts(sample_counts, &fir->clipped));
    next      = (uint8_t)(next + FIR_SAMPLE_BYTES);
    fir->next = next == size ? 0U : next;
}

PORT_OUTLINE int32_t fir_update(fir_t *fir, int32_t sample_counts)
{
    take(fir, sample_counts);
    const int32_t sum = port_fir_fold(fir->window, fir->config, fir->next);

    return fixed_clamp_counts(sum, &fir->clipped); /* |sum| <= 2^24: sum |c| < 2 */
}

PORT_OUTLINE int32_t fir_update_default(fir_t *fir, int32_t sample_counts)
{
    if (fir->config != fir_designs[0]) { return fir_update(fir, sample_counts); }
    take(fir, sample_counts);
    const int32_t sum = port_fir_fold_default(&fir->window[fir->next], fir->config);

    return fixed_clamp_counts(sum, &fir->clipped);
}

uint8_t fir_delay_half_samples(const fir_config_t *config)
{
    return (uint8_t)(config->taps - 1U);
}
