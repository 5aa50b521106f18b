/* SPDX-License-Identifier: MIT */
#include "weight_kf.h"

#include "fixed.h"
#include "port_assert.h"
#include "port_hot.h"
#include "port_weight_kf.h"

_Static_assert(WEIGHT_KF_FRACTION_BITS == 7, "fixed_counts_q7");

void weight_kf_init(weight_kf_t *kf, const weight_kf_config_t *config, int32_t first_counts)
{
    PORT_ASSERT(config->gain_len >= 1U);

    kf->config             = config;
    kf->step               = 0U;
    kf->clipped            = 0U;
    kf->estimate_counts_q7 = fixed_counts_q7(fixed_clamp_counts(first_counts, &kf->clipped));
}

static int32_t update_within(weight_kf_t *kf, int32_t measured_counts) /* |.| <= 2^23 */
{
    const uint8_t step = kf->step;
    const uint8_t next = (uint8_t)(step + 1U);

    if (next != kf->config->gain_len) { kf->step = next; } /* else the steady gain is held */
    /* The gain is at most 1: the estimate never passes the measurement. */
    return port_weight_kf_step(&kf->estimate_counts_q7, measured_counts,
                               &kf->config->gain_q15[step]);
}

/* Aside, so that the usual way pays nothing for it. */
__attribute__((noinline)) static int32_t update_clamped(weight_kf_t *kf, int32_t measured_counts)
{
    return update_within(kf, fixed_rail_counts(measured_counts, &kf->clipped));
}

PORT_OUTLINE int32_t weight_kf_update(weight_kf_t *kf, int32_t measured_counts)
{
    if (!fixed_is_counts(measured_counts)) { return update_clamped(kf, measured_counts); }
    return update_within(kf, measured_counts);
}
