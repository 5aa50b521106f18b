/* SPDX-License-Identifier: MIT */
#include "weight_kf.h"

#include "fixed.h"
#include "port_assert.h"
#include "port_outline.h"
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

PORT_OUTLINE int32_t weight_kf_update(weight_kf_t *kf, int32_t measured_counts)
{
    return port_weight_kf_step(kf, measured_counts);
}
