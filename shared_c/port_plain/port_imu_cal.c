/* SPDX-License-Identifier: MIT */
#include "port_imu_cal.h"

enum { AXES = 3 };

bool port_imu_cal(const imu_cal_config_t *config, int16_t vector_b_counts[3])
{
    const int16_t old[AXES] = {vector_b_counts[0], vector_b_counts[1], vector_b_counts[2]};
    bool          clipped   = false;

    for (uint8_t row = 0U; row < AXES; ++row) {
        int32_t sum_q16 = 32768 - config->offset_q3[row] * (int32_t)8192;
        for (uint8_t at = 0U; at < AXES; ++at) {
            sum_q16 += (int32_t)config->matrix_q16[row][at] * old[at];
        }
        const int32_t wanted  = old[row] + (sum_q16 >> 16);
        const int16_t limited = (int16_t)(wanted > INT16_MAX   ? INT16_MAX
                                          : wanted < INT16_MIN ? INT16_MIN
                                                               : wanted);
        clipped = clipped || limited != wanted || old[row] == INT16_MIN || old[row] == INT16_MAX;
        vector_b_counts[row] = limited;
    }
    return clipped;
}
