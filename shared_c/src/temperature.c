/* SPDX-License-Identifier: MIT */
#include "temperature.h"

#include "fixed.h"
#include "port_clamp.h"
#include "port_outline.h"
#include "port_reach.h"
#include "port_wide.h"
#include "temperature_limits.h"

enum {
    STEP_MAX_Q1    = 2 * TEMPERATURE_STEP_MAX_CENTI,
    SMOOTHING_HALF = 1 << (TEMPERATURE_SMOOTHING_SHIFT - 1)
};

/* Shares of 2^32. */
#define ZERO_Q7_SCALE   UINT32_C(343597384)  /* Q4 * 1/100 K to counts in Q7: 2^7 / 1600 */
#define SHARE_Q32_SCALE UINT32_C(2882303762) /* 4 ppm Q4 * 1/100 K to a share: 2^26 / 10^8 */

_Static_assert(2L * (TEMPERATURE_HIGHEST_CENTI - (long)TEMPERATURE_LOWEST_CENTI) < 32767L,
               "any two temperatures differ by an int16 in Q1");

static bool is_temperature(int16_t centi)
{
    return centi >= TEMPERATURE_LOWEST_CENTI && centi <= TEMPERATURE_HIGHEST_CENTI;
}

bool temperature_is_lawful(const temperature_config_t *config)
{
    return fixed_is_counts(config->origin_counts) &&
           config->reference_centi >= -TEMPERATURE_HIGHEST_CENTI &&
           config->reference_centi <= TEMPERATURE_HIGHEST_CENTI &&
           config->span_ppm_per_k_q4 >= -TEMPERATURE_SPAN_MAX_PPM_PER_K_Q4 &&
           config->span_ppm_per_k_q4 <= TEMPERATURE_SPAN_MAX_PPM_PER_K_Q4;
}

void temperature_init(temperature_t *temperature, const temperature_config_t *config)
{
    *temperature = (temperature_t){.config = config};
}

PORT_OUTLINE int16_t temperature_centi(const temperature_t *temperature)
{
    return (int16_t)((temperature->smoothed_q1 + 1) >> 1);
}

void temperature_refresh(temperature_t *temperature)
{
    const temperature_config_t *config      = temperature->config;
    int16_t                     above_centi = 0; /* the reference; |.| <= 17000 */

    if (temperature->known && config->on != 0U) {
        above_centi = (int16_t)(temperature_centi(temperature) - config->reference_centi);
    }
    temperature->zero_q7 = /* of a product < 2^29.1: < 2^25.5 */
        port_wide_share((int32_t)config->zero_counts_per_k_q4 * above_centi, ZERO_Q7_SCALE);
    temperature->span_q32 = /* of a product <= 2.8e8: < 2^27.5 */
        port_wide_share((int32_t)(int16_t)(config->span_ppm_per_k_q4 * 4) * above_centi,
                        SHARE_Q32_SCALE);
}

PORT_OUTLINE void temperature_update(temperature_t *temperature, int16_t measured_centi)
{
    if (!is_temperature(measured_centi)) {
        fixed_count(&temperature->refused);
        return;
    }
    int16_t step_q1 = (int16_t)(2 * measured_centi); /* in place of an unknown temperature, 0 */
    if (temperature->known) {
        step_q1 = (int16_t)(step_q1 - temperature->smoothed_q1); /* |.| <= 25 000 */
        if (step_q1 > STEP_MAX_Q1) { step_q1 = STEP_MAX_Q1; }
        if (step_q1 < -STEP_MAX_Q1) { step_q1 = -STEP_MAX_Q1; }
        step_q1 = (int16_t)((step_q1 + SMOOTHING_HALF) >> TEMPERATURE_SMOOTHING_SHIFT);
    }
    temperature->known       = true;
    temperature->smoothed_q1 = (int16_t)(temperature->smoothed_q1 + step_q1);
    temperature_refresh(temperature);
}

int32_t temperature_correct(temperature_t *temperature, int32_t raw_counts)
{
    temperature = PORT_REACH(temperature);

    int32_t span_counts = raw_counts - temperature->config->origin_counts;
    int32_t share_q32   = temperature->span_q32;

    if (share_q32 < 0) {
        share_q32   = -share_q32;
        span_counts = -span_counts;
    }
    const int32_t drift_q7 = temperature->zero_q7 + /* |span_counts| < 2^24: < 2^27.1 */
                             port_wide_share(port_to_q7(span_counts), (uint32_t)share_q32);

    return fixed_clamp_counts(raw_counts - port_from_q7(drift_q7), &temperature->clipped);
}
