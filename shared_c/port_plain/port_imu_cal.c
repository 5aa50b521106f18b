/* SPDX-License-Identifier: MIT */
#include "port_imu_cal.h"

enum { AXES = 3 };

static bool on_a_rail(int32_t value)
{
    return value <= INT16_MIN || value >= INT16_MAX;
}

bool port_imu_cal(const imu_cal_t *cal, const int16_t raw_b_counts[3], int16_t true_b_counts[3])
{
    const int16_t raw[AXES] = {raw_b_counts[0], raw_b_counts[1], raw_b_counts[2]};
    bool          railed    = false;

    for (uint8_t row = 0U; row < AXES; ++row) {
        int32_t sum = cal->added_q16[row];
        for (uint8_t at = 0U; at < AXES; ++at) {
            sum += (int32_t)cal->config->matrix_q16[row][at] * raw[at];
        }
        const int32_t wanted = raw[row] + (sum >> 16);
        railed               = railed || on_a_rail(raw[row]) || on_a_rail(wanted);
        true_b_counts[row]   = (int16_t)(wanted > INT16_MAX   ? INT16_MAX
                                         : wanted < INT16_MIN ? INT16_MIN
                                                              : wanted);
    }
    return railed;
}
