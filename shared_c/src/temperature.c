/* SPDX-License-Identifier: MIT */
#include "temperature.h"

#include "fixed.h"
#include "port_assert.h"
#include "temperature_limits.h"

#define STEP_MAX_Q8 ((int32_t)TEMPERATURE_STEP_MAX_CENTI * 256)

enum {
    SMOOTHING_HALF        = 1 << (TEMPERATURE_SMOOTHING_SHIFT - 1),
    CENTI_MAX             = TEMPERATURE_HIGHEST_CENTI - TEMPERATURE_LOWEST_CENTI,
    KELVIN_Q8_A_CENTI_Q13 = 20971, /* 2.56, short by 2.5e-5 of it */
    SHARE_Q20_A_PPM_Q38   = 17180  /* a share of 1 is 10^6 ppm: 2^26 * 2^8 / 10^6, over by 7.6e-6 */
};

_Static_assert(CENTI_MAX * 2.56 < 32767.0, "any two temperatures differ by an int16 in Q8");

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
    PORT_ASSERT(temperature_is_lawful(config));

    *temperature = (temperature_t){.config = config};
}

int16_t temperature_centi(const temperature_t *temperature)
{
    return (int16_t)((temperature->smoothed_q8 + 128) >> 8);
}

/* Once for all that multiply here: the multiplication is written out where it stands. */
static int32_t share_of(int32_t value, uint16_t share_q15)
{
    return fixed_mul_q15(value, share_q15);
}

void temperature_refresh(temperature_t *temperature)
{
    const temperature_config_t *config   = temperature->config;
    int16_t                     above_q8 = 0; /* K above the reference */

    if (temperature->known && config->on != 0U) {
        const int32_t above_centi = (int32_t)temperature_centi(temperature) -
                                    config->reference_centi;                  /* |.| <= 12500 */
        above_q8 = (int16_t)share_of(above_centi * 4, KELVIN_Q8_A_CENTI_Q13); /* |.| <= 31999 */
    }
    const int32_t zero_q12 = port_mul_i16(config->zero_counts_per_k_q4, above_q8); /* < 2^30 */
    const int32_t ppm_q12  = port_mul_i16(config->span_ppm_per_k_q4, above_q8); /* <= 127 996 000 */
    const int32_t share_q31 = share_of(ppm_q12, SHARE_Q20_A_PPM_Q38);           /* <= 67 107 278 */
    const int16_t share_q20 = (int16_t)((share_q31 + 1024) >> 11);              /* <= 32 767 */

    temperature->zero_q5    = (zero_q12 + 64) >> 7;
    temperature->span_falls = share_q20 < 0;
    temperature->span_q20   = (uint16_t)(share_q20 < 0 ? -share_q20 : share_q20);
}

void temperature_update(temperature_t *temperature, int16_t measured_centi)
{
    if (!is_temperature(measured_centi)) {
        fixed_count(&temperature->refused);
        return;
    }
    const int32_t measured_q8 = (int32_t)measured_centi * 256;
    if (temperature->known) {
        int32_t step_q8 = measured_q8 - temperature->smoothed_q8; /* |.| <= 12500 * 2^8 */
        if (step_q8 > STEP_MAX_Q8) { step_q8 = STEP_MAX_Q8; }
        if (step_q8 < -STEP_MAX_Q8) { step_q8 = -STEP_MAX_Q8; }
        temperature->smoothed_q8 += (step_q8 + SMOOTHING_HALF) >> TEMPERATURE_SMOOTHING_SHIFT;
    } else {
        temperature->smoothed_q8 = measured_q8;
        temperature->known       = true;
    }
    temperature_refresh(temperature);
}

int32_t temperature_correct(temperature_t *temperature, int32_t raw_counts)
{
    const int32_t origin_counts = temperature->config->origin_counts;
    const int32_t span_counts   = temperature->span_falls ? origin_counts - raw_counts
                                                          : raw_counts - origin_counts;
    const int32_t drift_q5 = temperature->zero_q5 + share_of(span_counts, temperature->span_q20);

    /* |span_counts| < 2^24 and shares are below 1, zero_q5 <= 2^23: |drift_q5| < 2^25 */
    return fixed_clamp_counts(raw_counts - ((drift_q5 + 16) >> 5), &temperature->clipped);
}
