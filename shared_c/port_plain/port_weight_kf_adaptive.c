/* SPDX-License-Identifier: MIT */
#include "port_weight_kf_adaptive.h"

#include <stdbool.h>

enum { ROOT_HALF_PI_Q9 = 642 };

static uint32_t times_q16(uint32_t value, uint32_t gain_q16)
{
    return (uint32_t)(((uint64_t)value * gain_q16 + (1U << 15)) >> 16);
}

/* The gain in Q16; the variance it leaves goes to the state. */
static uint32_t gain(weight_kf_adaptive_t *kf, uint32_t sigma_q8, uint32_t jump_q5)
{
    const uint32_t noise_var = sigma_q8 * sigma_q8;
    const uint32_t predicted = kf->var_q16 + kf->config->process_var_q16;
    const uint32_t total     = predicted + noise_var;
    const uint32_t jumped    = jump_q5 * sigma_q8;
    const bool     is_open   = jumped > predicted;
    const uint32_t over      = is_open ? jumped : predicted;
    const uint64_t scaled    = (uint64_t)(over < total ? over : total) << 16;
    const uint32_t gain_q16  = over < total ? (uint32_t)(scaled / total) : UINT16_MAX;
    const uint32_t rest      = (uint32_t)(scaled - (uint64_t)gain_q16 * total);

    kf->var_q16 = is_open ? times_q16(noise_var, gain_q16)
                          : predicted - times_q16(predicted + (rest >> 16), gain_q16);
    return gain_q16;
}

static void learn(weight_kf_adaptive_t *kf, int32_t left_q7, int32_t cap_q7)
{
    const int32_t low    = (int32_t)kf->config->noise_min_q8 << 8;
    const int32_t high   = (int32_t)kf->config->noise_max_q8 << 8;
    const int32_t before = (int32_t)kf->noise_q16;
    const int32_t taught = ROOT_HALF_PI_Q9 * (left_q7 < cap_q7 ? left_q7 : cap_q7);
    const int32_t learnt = before + ((taught - before + (1 << 7)) >> 8);

    kf->noise_q16 = (uint32_t)(learnt < low ? low : learnt > high ? high : learnt);
}

int32_t port_weight_kf_adaptive_step(weight_kf_adaptive_t *kf, int32_t counts,
                                     uint8_t margin_sigmas)
{
    const int32_t sigma_q8  = (int32_t)(kf->noise_q16 >> 8);
    const int32_t margin_q7 = (sigma_q8 * margin_sigmas) >> 1;
    const int64_t x_q7      = kf->estimate_counts_q7;
    const int64_t z_q7      = (int64_t)counts * 128;
    const int32_t side      = z_q7 < x_q7 ? -1 : 1;
    const int64_t size_q7   = (z_q7 - x_q7) * side;
    int64_t       least_q7  = size_q7;

    for (uint8_t at = 0U; at < 2U; ++at) {
        const int64_t other_q7 = (kf->before_counts_q7[at] - x_q7) * side;
        if (other_q7 < least_q7) { least_q7 = other_q7; }
    }
    const int64_t  jump_q7  = least_q7 > margin_q7 ? least_q7 - margin_q7 : 0;
    const int32_t  jump_q5  = jump_q7 >> 2 > UINT16_MAX ? UINT16_MAX : (int32_t)(jump_q7 >> 2);
    const uint32_t gain_q16 = gain(kf, (uint32_t)sigma_q8, (uint32_t)jump_q5);
    const int64_t  left_q7  = size_q7 - jump_q7;
    const int32_t  taken_q7 = left_q7 < 2 * sigma_q8 ? (int32_t)left_q7 : 2 * sigma_q8;
    int32_t        cap_q7   = 4 * ((sigma_q8 >> 1) - jump_q5);

    if (cap_q7 < sigma_q8 >> 1) { cap_q7 = sigma_q8 >> 1; }
    const int64_t move_q23  = jump_q7 * 65536 + (int64_t)taken_q7 * gain_q16;
    const int64_t moved_q23 = x_q7 * 65536 + kf->fraction_q23 + move_q23 * side;
    kf->estimate_counts_q7  = (int32_t)(moved_q23 >> 16);
    kf->fraction_q23        = (uint16_t)moved_q23;
    kf->before_counts_q7[1] = kf->before_counts_q7[0];
    kf->before_counts_q7[0] = (int32_t)z_q7;
    learn(kf, taken_q7, cap_q7);
    return kf->estimate_counts_q7;
}
