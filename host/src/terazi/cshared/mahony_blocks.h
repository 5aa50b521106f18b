/* SPDX-License-Identifier: MIT */
/* mahony_blocks - the attitude filter over arrays for Python. */
#ifndef MAHONY_BLOCKS_H
#define MAHONY_BLOCKS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "mahony.h"
#include "rest.h"

/* Vectors lie one behind the other: three values each, four of a quaternion.  bias_q16 may be NULL
 * (none), one vector (bias_step 0) or one a sample (bias_step 3); mag_b_counts may be NULL.
 * as_state: the filter's own quaternion, which ATTITUDE tells, in place of mahony_quaternion's. */
void mahony_blocks_run(mahony_modes_t *modes, const int16_t gyro_b_counts[],
                       const int16_t acc_b_counts[], const int16_t *mag_b_counts,
                       const int32_t *bias_q16, size_t bias_step, bool as_state,
                       int32_t quat_wb_q30[], size_t count);

/* The same with the bias that `rest` learns on the way, as the device does. */
void mahony_blocks_run_rest(mahony_modes_t *modes, rest_t *rest, const int16_t gyro_b_counts[],
                            const int16_t acc_b_counts[], const int16_t *mag_b_counts,
                            int32_t quat_wb_q30[], size_t count);

#endif
