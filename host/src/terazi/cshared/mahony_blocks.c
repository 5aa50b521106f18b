/* SPDX-License-Identifier: MIT */
#include "mahony_blocks.h"

#include <string.h>

enum { AXES = 3, COMPONENTS = 4 };

static void take_quaternion(const mahony_t *mahony, bool as_state, int32_t quat_wb_q30[COMPONENTS])
{
    if (as_state) {
        memcpy(quat_wb_q30, mahony->step.quat_wb_q30, sizeof mahony->step.quat_wb_q30);
    } else {
        mahony_quaternion(mahony, quat_wb_q30);
    }
}

void mahony_blocks_run(mahony_modes_t *modes, const int16_t gyro_b_counts[],
                       const int16_t acc_b_counts[], const int16_t *mag_b_counts,
                       const int32_t *bias_q16, size_t bias_step, bool as_state,
                       int32_t quat_wb_q30[], size_t count)
{
    static const int32_t none_q16[AXES] = {0, 0, 0};

    for (size_t at = 0U; at < count; ++at) {
        mahony_modes_update(modes, &gyro_b_counts[AXES * at], &acc_b_counts[AXES * at],
                            bias_q16 == NULL ? none_q16 : &bias_q16[bias_step * at]);
        if (mag_b_counts != NULL) { mahony_update_mag(&modes->mahony, &mag_b_counts[AXES * at]); }
        take_quaternion(&modes->mahony, as_state, &quat_wb_q30[COMPONENTS * at]);
    }
}

void mahony_blocks_run_rest(mahony_modes_t *modes, rest_t *rest, const int16_t gyro_b_counts[],
                            const int16_t acc_b_counts[], const int16_t *mag_b_counts,
                            int32_t quat_wb_q30[], size_t count)
{
    for (size_t at = 0U; at < count; ++at) {
        const int16_t *const gyro = &gyro_b_counts[AXES * at];
        const int16_t *const acc  = &acc_b_counts[AXES * at];

        rest_update(rest, gyro, acc);
        mahony_modes_update(modes, gyro, acc, rest->bias_q16);
        if (mag_b_counts != NULL) { mahony_update_mag(&modes->mahony, &mag_b_counts[AXES * at]); }
        mahony_quaternion(&modes->mahony, &quat_wb_q30[COMPONENTS * at]);
    }
}
