/* SPDX-License-Identifier: MIT */
#include "weight_kf.h"

#include "fixed.h"
#include "port_assert.h"
#include "port_rom.h"

/* counts * 2^7, for -2^23 <= counts < 2^23. Up by a byte, which still fits in 32 bits, and down by
 * a bit: avr-gcc makes a loop of a shift by seven. */
static int32_t counts_to_q7(int32_t counts)
{
    _Static_assert(WEIGHT_KF_FRACTION_BITS == 7, "a byte less a bit");
    return (counts * 256) >> 1;
}

void weight_kf_init(weight_kf_t *kf, const weight_kf_config_t *config, int32_t first_counts)
{
    PORT_ASSERT(config->gain_len >= 1U);

    kf->config             = config;
    kf->step               = 0U;
    kf->clipped            = 0U;
    kf->estimate_counts_q7 = counts_to_q7(fixed_clamp_counts(first_counts, &kf->clipped));
}

int32_t weight_kf_update(weight_kf_t *kf, int32_t measured_counts)
{
    const int32_t  z_q7     = counts_to_q7(fixed_clamp_counts(measured_counts, &kf->clipped));
    const int32_t  diff_q7  = z_q7 - kf->estimate_counts_q7; /* |.| <= 2^31 - 2^7: both in 24.7 */
    const uint16_t gain_q15 = port_rom_u16(&kf->config->gain_q15[kf->step]);

    kf->estimate_counts_q7 += fixed_mul_q15(diff_q7, gain_q15); /* gain <= 1: never passes z */
    if (kf->step < kf->config->gain_len - 1U) { ++kf->step; }   /* else the steady gain is held */
    return kf->estimate_counts_q7;
}
