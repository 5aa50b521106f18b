/* SPDX-License-Identifier: MIT */
/* imu_cal - takes offset, scale, misalignment and the offsets' temperature slope off an IMU.
 *
 * Model     true = M (raw - offset - slope (T - T_ref))   (Tedaldi et al. 2014, eq. 9, 10, with the
 *           slope added), written as true = raw + D raw - o(T) with D = M - I and o = M (offset +
 *           slope (T - T_ref)), so that an uncalibrated board has a configuration of zeros
 * Result    raw + floor(sum / 2^16 + 1/2) in unbounded integers, then saturated to int16: one
 *           rounding, half up, for all three products and the offset
 * Formats   raw and result: counts, int16    D: Q16 in int16, so +-1/2, and sum of magnitudes of a
 *           row <= 32767 (0.5): a scale off by 5 % and axes off by 2 % (MPU-6050) take a seventh
 *           of that, a magnetometer's soft iron may need more    offset: counts Q16, below 2^29
 *           (8192 counts)    slope: counts a temperature count, Q16, |slope| <= 2^14
 * Matrices  on raw axes: a board that stands otherwise turns its axes in the driver, not here
 * Bad data  a raw value or a result on a rail (-32768, 32767) is passed on, saturated, and its
 *           vector counted in `clipped`; apply cannot fail.  A configuration from outside is asked
 *           with imu_cal_is_lawful before it is used
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef IMU_CAL_H
#define IMU_CAL_H

#include <stdbool.h>
#include <stdint.h>

/* What one sensor of three axes needs; all zero is a perfect one. */
typedef struct {
    int16_t matrix_q16[3][3]; /* D = M - I, row by row */
    int16_t slope_q16[3];     /* of the offset, after M, counts a temperature count */
    int32_t offset_q16[3];    /* at the reference temperature, after M, counts */
} imu_cal_config_t;

typedef struct {
    const imu_cal_config_t *config;
    int32_t added_q16[3]; /* counts, Q16: half a count less the offset at the present temperature */
    uint16_t clipped;     /* vectors with a value on a rail, stops at 65535 */
} imu_cal_t;

/* The bounds above hold, so that nothing overflows. */
bool imu_cal_is_lawful(const imu_cal_config_t *config);

/* Begin at the reference temperature.  config must be lawful, and stay where it is. */
void imu_cal_init(imu_cal_t *cal, const imu_cal_config_t *config);

/* The sensor is now so much warmer than at the reference; its offset is taken at this temperature
 * until told otherwise. A temperature on its way needs no more than one call a second. */
void imu_cal_set_temperature(imu_cal_t *cal, int16_t above_reference_counts);

/* Calibrate one vector.  The two may be the same array. */
void imu_cal_apply(imu_cal_t *cal, const int16_t raw_b_counts[3], int16_t true_b_counts[3]);

#endif
