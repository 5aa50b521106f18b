/* SPDX-License-Identifier: MIT */
/* imu_blocks - loops of the inertial modules over arrays for Python. */
#ifndef IMU_BLOCKS_H
#define IMU_BLOCKS_H

#include <stddef.h>
#include <stdint.h>

#include "imu_cal.h"
#include "rest.h"

/* Vectors lie one behind the other, three values each, and are changed where they lie. */
void imu_blocks_cal(imu_cal_t *cal, int16_t vectors_b_counts[], size_t count);

void imu_blocks_turn(uint8_t orientation, int16_t vectors_b_counts[], size_t count);

/* A bias of three values and flags after each sample. */
void imu_blocks_rest(rest_t *rest, const int16_t gyro_b_counts[], const int16_t acc_b_counts[],
                     int32_t bias_q16[], uint8_t flags[], size_t count);

#endif
