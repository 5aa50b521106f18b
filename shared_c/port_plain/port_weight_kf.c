/* SPDX-License-Identifier: MIT */
#include "port_weight_kf.h"

#include "port_clamp.h"
#include "port_fixed.h"
#include "port_rom.h"

int32_t port_weight_kf_step(weight_kf_t *kf, int32_t measured_counts)
{
    const int32_t  counts   = port_clamp_counts(measured_counts, &kf->clipped); /* |.| <= 2^23 */
    const uint16_t gain_q15 = port_rom_u16(&kf->config->gain_q15[kf->step]);
    const uint8_t  next     = (uint8_t)(kf->step + 1U);

    if (next != kf->config->gain_len) { kf->step = next; }
    /* The gain is at most 1: the estimate never passes the measurement. */
    kf->estimate_counts_q7 += port_mul_q15(counts * 128 - kf->estimate_counts_q7, gain_q15);
    return kf->estimate_counts_q7;
}
