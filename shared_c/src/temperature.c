/* SPDX-License-Identifier: MIT */
#include "temperature.h"

#include "fixed.h"
#include "temperature_limits.h"

enum {
    STEP_MAX_Q1     = 2 * TEMPERATURE_STEP_MAX_CENTI,
    SMOOTHING_HALF  = 1 << (TEMPERATURE_SMOOTHING_SHIFT - 1),
    ZERO_Q5_SCALE   = 20972, /* Q4 * 1/100 K to counts in Q5: 1/50 = 0.64 / 2^5 */
    SHARE_Q20_SCALE = 21990  /* ppm Q4 * 1/100 K to a share in Q20: 2^16 / 10^8 = 0.671 / 2^10 */
};

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

/* Once for all that multiply here: the multiplication is written out where it stands. */
static int32_t share_of(int32_t value, uint16_t share_q15)
{
    return fixed_mul_q15(value, share_q15);
}

static int32_t drift(int16_t slope_q4, int16_t above_centi, uint16_t scale_q15)
{
    return share_of(port_mul_i16(slope_q4, above_centi),
                    scale_q15); /* |.| <= 2^15 * 12500 < 2^29 */
}

void temperature_refresh(temperature_t *temperature)
{
    const temperature_config_t *config      = temperature->config;
    int16_t                     above_centi = 0; /* the reference; |.| <= 12500 */

    if (temperature->known && config->on != 0U) {
        above_centi = (int16_t)(temperature_centi(temperature) - config->reference_centi);
    }
    temperature->zero_q5 = (drift(config->zero_counts_per_k_q4, above_centi, ZERO_Q5_SCALE) + 16) >>
                           5; /* < 2^23 */
    const int32_t share_q20 = (drift(config->span_ppm_per_k_q4, above_centi, SHARE_Q20_SCALE) +
                               512) >>
                              10; /* <= 2^15 */
    temperature->span_falls = share_q20 < 0;
    temperature->span_q20   = (uint16_t)(share_q20 < 0 ? -share_q20 : share_q20);
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
    const int32_t drift_q5 = temperature->zero_q5 + share_of(span_counts, temperature->span_q20);

    /* |span_counts| < 2^24 and shares at most 2^15 / 2^20, zero_q5 < 2^23: |drift_q5| < 2^25 */
    return fixed_clamp_counts(raw_counts - ((drift_q5 + 16) >> 5), &temperature->clipped);
}
