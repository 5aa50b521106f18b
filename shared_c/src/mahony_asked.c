/* SPDX-License-Identifier: MIT */
/* mahony_asked - what is asked of the filter: attitude, vertical, free acceleration. */
#include "mahony_internal.h"

#define ONE_Q28 (INT32_C(1) << 28)

void mahony_quaternion(const mahony_t *mahony, int32_t quat_wb_q30[4])
{
    int16_t upper_q14[4];
    int32_t error_q28 = -ONE_Q28;

    for (uint8_t i = 0U; i < 4U; ++i) {
        const int32_t value = mahony->step.quat_wb_q30[i];
        const int16_t upper = (int16_t)((value + INT32_C(0x8000)) >> 16);
        const int16_t rest  = (int8_t)(value >> 8); /* (upper 2^8 + rest)^2, less rest^2 */

        error_q28 += port_mul_i16(upper, upper) + (port_mul_i16(upper, rest) >> 7);
        upper_q14[i]   = upper;
        quat_wb_q30[i] = value;
    }
    /* 1/sqrt(1 + e) = 1 - e/2 + 3/8 e^2, |e| < 2^-8: what follows is below 2e-8 */
    const int16_t half_q24   = (int16_t)((error_q28 * 8 + 128) >> 8);
    const int16_t square_q24 = (int16_t)(port_square_i16(half_q24) >> 24);
    const int16_t factor_q24 = (int16_t)(square_q24 + (square_q24 >> 1) - half_q24);

    for (uint8_t i = 0U; i < 4U; ++i) {
        quat_wb_q30[i] += (port_mul_i16(upper_q14[i], factor_q24) + 128) >> 8;
    }
}

void mahony_up(const mahony_t *mahony, int16_t up_b_q14[3])
{
    const int16_t *const east = mahony->step.east_b_q14, *const north = mahony->step.north_b_q14;
    uint8_t next = 1U, last = 2U;

    for (uint8_t i = 0U; i < 3U; ++i) {
        const int32_t up_q28 = (int32_t)east[next] * north[last] -
                               (int32_t)east[last] * north[next];

        up_b_q14[i] = (int16_t)((up_q28 * 4 + INT32_C(0x8000)) >> 16); /* |.| <= 1.004 2^28 */
        next        = last;
        last        = i;
    }
}

void mahony_free_acceleration(const mahony_t *mahony, const int16_t acc_b_counts[3],
                              int16_t free_b_counts[3])
{
    int16_t up_b_q14[3];

    mahony_up(mahony, up_b_q14);
    for (uint8_t i = 0U; i < 3U; ++i) {
        const int32_t gravity = port_mul_i16(up_b_q14[i], (int16_t)mahony->config->acc_one_g);

        free_b_counts[i] = mahony_limit_i16(acc_b_counts[i] - (((gravity >> 8) + 32) >> 6));
    }
}
