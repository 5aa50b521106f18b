/* SPDX-License-Identifier: MIT */
/* port_imu_cal - the nine products of a calibration, and its three sums that saturate.
 *
 * Model     true[i] = raw[i] + ((added[i] + sum_j D[i][j] raw[j]) >> 16), limited to int16
 * Bounds    the sum fits int32 (imu_cal.h's contract), in whatever order
 * Places    raw and true may be the same array
 */
#ifndef PORT_IMU_CAL_H
#define PORT_IMU_CAL_H

#include "imu_cal.h"

/* Gives whether any value, raw or true, stands on a rail. */
bool port_imu_cal(const imu_cal_t *cal, const int16_t raw_b_counts[3], int16_t true_b_counts[3]);

#endif
