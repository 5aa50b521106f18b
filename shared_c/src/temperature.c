/* SPDX-License-Identifier: MIT */
#include "temperature.h"

#include "fixed.h"
#include "port_wide.h"
#include "temperature_limits.h"

enum {
    STEP_MAX_Q1    = 2 * TEMPERATURE_STEP_MAX_CENTI,
    SMOOTHING_HALF = 1 << (TEMPERATURE_SMOOTHING_SHIFT - 1)
};

/* Thrice called, once written. */
#define OUTLINE __attribute__((noinline))

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
    return fixed_is_counts(config->origin_counts) && is_temperature(config->reference_centi) &&
           config->span_ppm_per_k_q4 >= -TEMPERATURE_SPAN_MAX_PPM_PER_K_Q4 &&
           config->span_ppm_per_k_q4 <= TEMPERATURE_SPAN_MAX_PPM_PER_K_Q4;
}

void temperature_init(temperature_t *temperature, const temperature_config_t *config)
{
    *temperature = (temperature_t){.config = config};
}

int16_t temperature_centi(const temperature_t *temperature)
{
    return (int16_t)((temperature->smoothed_q1 + 1) >> 1);
}

/* value * share / 2^32, half away from zero. */
OUTLINE static int32_t scaled(int32_t value, uint32_t share_q32)
{
    if (value < 0) { return -(int32_t)port_wide_high(0U - (uint32_t)value, share_q32); }
    return (int32_t)port_wide_high((uint32_t)value, share_q32);
}

void temperature_refresh(temperature_t *temperature)
{
    const temperature_config_t *config      = temperature->config;
    int16_t                     above_centi = 0; /* the reference; |.| <= 12500 */

    if (temperature->known && config->on != 0U) {
        above_centi = (int16_t)(temperature_centi(temperature) - config->reference_centi);
    }
    const int32_t zero  = port_mul_i16(config->zero_counts_per_k_q4, above_centi); /* < 2^29 */
    const int32_t share = port_mul_i16(config->span_ppm_per_k_q4, above_centi);    /* <= 5e7 */

    temperature->zero_q7    = scaled(zero, ZERO_Q7_SCALE); /* < 2^25.4 */
    temperature->span_falls = share < 0;
    temperature->span_q32   = (uint32_t)scaled((share < 0 ? -share : share) * 4, SHARE_Q32_SCALE);
}

void temperature_update(temperature_t *temperature, int16_t measured_centi)
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
    const int32_t origin_counts = temperature->config->origin_counts;
    const int32_t span_counts   = temperature->span_falls ? origin_counts - raw_counts
                                                          : raw_counts - origin_counts;
    const int32_t drift_q7      = temperature->zero_q7 + /* |span_counts| < 2^24, shares <= 2^27 */
                             scaled(span_counts * 128, temperature->span_q32);

    return fixed_clamp_counts(raw_counts - ((drift_q7 + 64) >> 7), &temperature->clipped);
}
