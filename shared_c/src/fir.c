/* SPDX-License-Identifier: MIT */
#include "fir.h"

#include "fir_designs.h"
#include "fixed.h"
#include "port_assert.h"
#include "port_fir.h"
#include "port_outline.h"

enum { HALF_UNITY_Q15 = 16384, UNITY_Q15 = 32768 };

_Static_assert(FIR_SAMPLE_BYTES *FIR_TAPS_MAX <= 255, "byte offsets into the window are uint8_t");
_Static_assert(FIR_DESIGN_LOWPASS32 == 0, "the default design");
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

/* The default design's window holds its samples twice: any taps neighbours are then in order of
 * age, which its straight code needs. */
static void take(fir_t *fir, int32_t sample_counts)
{
    port_fir_take(fir, fixed_clamp_counts(sample_counts, &fir->clipped), &fir_lowpass32);
}

void fir_init(fir_t *fir, const fir_config_t *config, int32_t first_counts)
{
    PORT_ASSERT(config->taps >= 2U && config->taps <= FIR_TAPS_MAX);

    fir->config  = config;
    fir->next    = 0U;
    fir->clipped = 0U;
    first_counts = fixed_clamp_counts(first_counts, &fir->clipped); /* it counts once */
    do {
        port_fir_take(fir, first_counts, &fir_lowpass32);
    } while (fir->next != 0U);
}

int32_t fir_update(fir_t *fir, int32_t sample_counts)
{
    take(fir, sample_counts);
    const int32_t sum = port_fir_fold(fir->window, fir->config, fir->next);

    return fixed_clamp_counts(sum, &fir->clipped); /* |sum| <= 2^24: sum |c| < 2 */
}

PORT_OUTLINE int32_t fir_update_default(fir_t *fir, int32_t sample_counts)
{
    if (fir->config != &fir_lowpass32) { return fir_update(fir, sample_counts); }
    take(fir, sample_counts);
    const int32_t sum = port_fir_fold_default(&fir->window[fir->next], fir->config);

    return fixed_clamp_counts(sum, &fir->clipped);
}

uint8_t fir_delay_half_samples(const fir_config_t *config)
{
    return (uint8_t)(config->taps - 1U);
}
