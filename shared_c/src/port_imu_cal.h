/* SPDX-License-Identifier: MIT */
/* port_imu_cal - the nine products of a calibration, and its three sums that saturate; and the turn
 * of its axes.
 *
 * Model     new[i] = old[i] + ((2^15 - 2^13 offset_q3[i] + sum_j D[i][j] old[j]) >> 16), limited to
 *           int16
 * Bounds    the sum fits int32 (imu_cal.h's contract), in whatever order
 */
#ifndef PORT_IMU_CAL_H
#define PORT_IMU_CAL_H

#include "imu_cal.h"

/* Gives whether an old value stood on a rail or a new one was limited. */
bool port_imu_cal(const imu_cal_config_t *config, int16_t vector_b_counts[3]);

/* imu_cal_turn, for a lawful orientation. */
void port_imu_turn(uint8_t orientation, int16_t vector_b_counts[3]);

#endif
