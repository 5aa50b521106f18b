/* SPDX-License-Identifier: MIT */
/* mahony_start - how the estimate comes upright. */
#include "mahony_internal.h"
#include "port_i16.h"
#include "port_turn.h"

enum { RATE_MAX = 32000 }; /* times a row below 2^29 */

static int16_t limited(int32_t rate)
{
    if (rate > RATE_MAX) { return RATE_MAX; }
    return rate < -RATE_MAX ? -RATE_MAX : (int16_t)rate;
}

/* gyr and, in a start, what stands the estimate upright: a turn of the world about the level axis
 * across the acceleration that waits. Never zero: a board on its back does not stay there. */
uint8_t mahony_stand(mahony_t *mahony, const int16_t gyro_b_counts[3],
                     const int16_t acc_b_counts[3], const int32_t bias_q16[3])
{
    mahony_step_t *const step       = &mahony->step;
    const bool           waits_east = mahony_next_axis(step) == 0U;
    const int16_t *const row        = waits_east ? step->north_b_q14 : step->east_b_q14;
    int32_t              level      = step->level_q14;
    int16_t              rate_b[3];

    for (uint8_t i = mahony->config->start_shift; i != 0U; --i) { level >>= 1; }
    const int16_t turn = (int16_t)(limited(waits_east ? -level : level) | 1);

    for (uint8_t i = 0U; i < 3U; ++i) {
        const int32_t turn_q16 = (int32_t)turn * row[i] * 4 + INT32_C(0x8000);

        rate_b[i] = port_add_sat_i16(gyro_b_counts[i], (int16_t)(turn_q16 >> 16));
    }
    return port_turn(step, rate_b, acc_b_counts, bias_q16);
}
