/* SPDX-License-Identifier: MIT */
/* mahony_modes - what is not usual: no average, classic, ki, several steps a sample. */
#include <string.h>

#include "mahony_internal.h"
#include "port_assert.h"
#include "port_dot.h"
#include "port_root.h"

#define INTEGRAL_MAX_Q22 (INT32_C(328) << 22) /* 20 deg/s, the gyroscope's worst offset */
#define MEAN_MAX_Q14     (INT32_C(1) << 27)

bool mahony_modes_is_lawful(const mahony_modes_config_t *config)
{
    return mahony_is_lawful(&config->usual) && config->steps >= 1U &&
           config->mode <= MAHONY_CLASSIC && config->integral <= INT16_MAX &&
           (config->usual.lowpass_q16 != 0U) == (config->mode == MAHONY_SECOND_ORDER);
}

void mahony_modes_init(mahony_modes_t *modes, const mahony_modes_config_t *config)
{
    PORT_ASSERT(mahony_modes_is_lawful(config));

    memset(modes, 0, sizeof *modes);
    mahony_init(&modes->mahony, &config->usual);
    modes->config = config;
}

/* ki: a bias of the gyroscope is what the world is turned against, in the long run. */
static void integrate(mahony_modes_t *modes)
{
    const mahony_step_t *const step  = &modes->mahony.step;
    const int16_t *const       about = mahony_next_axis(step) == 0U ? step->east_b_q14
                                                                    : step->north_b_q14;
    const int32_t              more  = modes->integral_res +
                         port_mul_i16(step->correct_q19, (int16_t)modes->config->integral);

    modes->integral_res = (uint16_t)more;
    for (uint8_t i = 0U; i < 3U; ++i) {
        int32_t bias_q22 = modes->integral_q22[i]; /* 328 2^22 + 2^29 < 2^31 */

        bias_q22 -= port_mul_i16(about[i], (int16_t)(more >> 16));
        if (bias_q22 > INTEGRAL_MAX_Q22) { bias_q22 = INTEGRAL_MAX_Q22; }
        if (bias_q22 < -INTEGRAL_MAX_Q22) { bias_q22 = -INTEGRAL_MAX_Q22; }
        modes->integral_q22[i] = bias_q22;
    }
}

/* level / |acc|, in Q25; |level| is limited to |acc|, as rows may be longer than 1 by 6e-4. */
static int32_t normalised_q25(int32_t level_q14, const int16_t acc_b_counts[3])
{
    uint32_t square = 0U; /* of half of each where one is large: <= 3 2^28 */
    uint8_t  shift  = 0U;

    for (uint8_t i = 0U; i < 3U; ++i) {
        const int16_t half = (int16_t)(acc_b_counts[i] >> 1);

        square += (uint32_t)((int32_t)half * half);
    }
    if (square < UINT32_C(0x00400000)) { /* |acc| < 4096: four times as fine */
        square = 0U;
        shift  = 3U;
        for (uint8_t i = 0U; i < 3U; ++i) {
            const int16_t fine = (int16_t)(acc_b_counts[i] * 4);

            square += (uint32_t)((int32_t)fine * fine);
        }
    }
    const uint16_t length = port_root(square); /* |acc| 2^(shift - 1) */
    const uint32_t size   = (uint32_t)(level_q14 < 0 ? -level_q14 : level_q14);
    uint32_t       part   = (size >> (15U - shift)); /* as fine as that */

    if (part > length) { part = length; }
    const int32_t ratio_q25 = (int32_t)port_ratio_q15((uint16_t)part, length) * 1024;

    return level_q14 < 0 ? -ratio_q25 : ratio_q25;
}

/* Linear and classic: u is not an average but what two samples, or this one, say. */
static void follow(mahony_modes_t *modes, const int16_t acc_b_counts[3])
{
    mahony_step_t *const step      = &modes->mahony.step;
    const uint8_t        axis      = mahony_next_axis(step);
    const int16_t *const row       = axis == 0U ? step->east_b_q14 : step->north_b_q14;
    int32_t              level_q14 = port_dot(row, acc_b_counts);

    if (modes->config->mode == MAHONY_LINEAR) {
        level_q14 = (level_q14 + step->level_q14) >> 1; /* |.| <= 2^30.8 before */
        if (level_q14 >= MEAN_MAX_Q14) { level_q14 = MEAN_MAX_Q14 - 1; }
        if (level_q14 < -MEAN_MAX_Q14) { level_q14 = -MEAN_MAX_Q14; }
    } else {
        level_q14 = normalised_q25(level_q14, acc_b_counts);
    }
    step->level_w[axis].mean_q14 = level_q14;
}

/* The rest of a sample's turn where one step would be too large. */
static void repeat(mahony_step_t *step, uint8_t steps)
{
    const int32_t level_q14 = step->level_q14;
    const uint8_t sample    = step->sample;

    for (; steps != 0U; --steps) { mahony_bridge(step); }
    step->level_q14 = level_q14;
    step->sample    = sample;
}

void mahony_modes_update(mahony_modes_t *modes, const int16_t gyro_b_counts[3],
                         const int16_t acc_b_counts[3], const int32_t bias_q16[3])
{
    const bool started = !mahony_is_starting(&modes->mahony);
    int32_t    both_q16[3];

    if (started && modes->config->integral != 0U) { integrate(modes); }
    for (uint8_t i = 0U; i < 3U; ++i) { both_q16[i] = bias_q16[i] + (modes->integral_q22[i] >> 6); }
    if (started && modes->config->mode != MAHONY_SECOND_ORDER &&
        (acc_b_counts[0] | acc_b_counts[1] | acc_b_counts[2]) != 0) {
        follow(modes, acc_b_counts);
    }
    mahony_update(&modes->mahony, gyro_b_counts, acc_b_counts, both_q16);
    repeat(&modes->mahony.step, (uint8_t)(modes->config->steps - 1U));
}

void mahony_modes_gap(mahony_modes_t *modes, uint16_t samples)
{
    mahony_t *const mahony = &modes->mahony;

    if (!mahony_is_starting(mahony) && samples <= mahony->config->gap_max) {
        for (uint16_t left = samples; left != 0U; --left) {
            repeat(&mahony->step, (uint8_t)(modes->config->steps - 1U));
        }
    }
    mahony_gap(mahony, samples);
}
