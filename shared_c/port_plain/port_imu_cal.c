/* SPDX-License-Identifier: MIT */
#include "port_imu_cal.h"

enum {
    AXES      = 3,
    PART_AXIS = 3, /* bits of an orientation's code of one axis */
    NEGATED   = 4,
    CODE_BITS = 3
};

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

/* The axis of the part that the code names. */
static int16_t along(const int16_t vector[3], uint8_t code)
{
    const int16_t value = vector[code & PART_AXIS];

    if ((code & NEGATED) == 0U) { return value; }
    return value == INT16_MIN ? INT16_MAX : (int16_t)-value;
}

void port_imu_turn(uint8_t orientation, int16_t vector_b_counts[3])
{
    const uint8_t x = orientation & PART_AXIS, y_code = (uint8_t)(orientation >> CODE_BITS);
    const uint8_t y = y_code & PART_AXIS, after_x = (uint8_t)((x + 1U) % AXES);
    uint8_t       z_code = (uint8_t)(((orientation ^ y_code) & NEGATED) | (AXES - x - y));

    if (y != after_x) { z_code ^= NEGATED; }
    const int16_t body_x = along(vector_b_counts, orientation);
    const int16_t body_y = along(vector_b_counts, y_code);
    vector_b_counts[2]   = along(vector_b_counts, z_code);
    vector_b_counts[1]   = body_y;
    vector_b_counts[0]   = body_x;
}
