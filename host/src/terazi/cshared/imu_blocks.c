/* SPDX-License-Identifier: MIT */
#include "imu_blocks.h"

#include <string.h>

enum { AXES = 3 };

void imu_blocks_cal(imu_cal_t *cal, int16_t vectors_b_counts[], size_t count)
{
    for (size_t at = 0U; at < count; ++at) { imu_cal_apply(cal, &vectors_b_counts[AXES * at]); }
}

void imu_blocks_turn(uint8_t orientation, int16_t vectors_b_counts[], size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        imu_cal_turn(orientation, &vectors_b_counts[AXES * at]);
    }
}

void imu_blocks_rest(rest_t *rest, const int16_t gyro_b_counts[], const int16_t acc_b_counts[],
                     int32_t bias_q16[], uint8_t flags[], size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        flags[at] = rest_update(rest, &gyro_b_counts[AXES * at], &acc_b_counts[AXES * at]);
        memcpy(&bias_q16[AXES * at], rest->bias_q16, sizeof rest->bias_q16);
    }
}
