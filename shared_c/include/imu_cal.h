/* SPDX-License-Identifier: MIT */
/* imu_cal - takes offset, scale and misalignment off a sensor of three axes, and turns its axes
 * into the board's.
 *
 * Model     true = M (raw - offset)   (Tedaldi et al. 2014, eq. 9, 10), written as
 *           true = raw + D raw - o with D = M - I and o = M offset, so that a sensor that nobody
 *           calibrated has a configuration of zeros
 * Result    raw + floor(sum / 2^16 + 1/2) in unbounded integers, then saturated to int16: one
 *           rounding, half up, for all three products and the offset
 * Formats   raw and result: counts, int16    D: Q16 in int16, so +-1/2, and sum of magnitudes of a
 *           row <= 32767 (0.5): a scale off by 5 % and axes off by 2 % (MPU-6050) take a seventh
 *           of that, a magnetometer's soft iron may need more    o: counts Q3 in int16, +-4095.9
 *           counts    slope of o: counts a temperature count, Q16, |slope| <= 2^14
 * Turning   a signed permutation of the axes, without a mirror: it is exact, and follows the
 *           calibration, which is of the part and not of how it was glued on
 * Bad data  a raw value on a rail (-32768, 32767) or a result that had to be saturated is passed on
 *           and its vector counted in `clipped`; apply cannot fail. A configuration and an
 *           orientation from outside are asked with the two is_lawful before they are used
 * Context   single caller, not from an ISR.  Cost: firmware/budget.toml
 */
#ifndef IMU_CAL_H
#define IMU_CAL_H

#include <stdbool.h>
#include <stdint.h>

/* What one sensor of three axes needs; all zero is a perfect one. */
typedef struct {
    int16_t matrix_q16[3][3]; /* D = M - I, row by row */
    int16_t offset_q3[3];     /* o = M offset, counts */
} imu_cal_config_t;

typedef struct {
    const imu_cal_config_t *config;
    uint16_t clipped; /* vectors with a value that is not to be trusted, stops at 65535 */
} imu_cal_t;

enum { IMU_CAL_UPRIGHT = 8 }; /* the orientation that leaves every axis as it is */

/* The bounds above hold, so that nothing overflows. */
bool imu_cal_is_lawful(const imu_cal_config_t *config);

/* Begin.  config must be lawful at each apply, and stay where it is. */
void imu_cal_init(imu_cal_t *cal, const imu_cal_config_t *config);

/* Calibrate one vector, where it lies. */
void imu_cal_apply(imu_cal_t *cal, int16_t vector_b_counts[3]);

/* The configuration of a sensor so much warmer than at the reference: offset_q3 + slope T, half up
 * and limited to int16. |slope| <= 2^14. The two may be the same. */
void imu_cal_at_temperature(const imu_cal_config_t *reference, const int16_t slope_q16[3],
                            int16_t above_reference_counts, imu_cal_config_t *warm);

/* Orientation: bits 0-1 say which axis of the part is the board's x, 0..2, and bit 2 that it
 * points the other way; bits 3-4 and 5 say the same of the board's y; its z is x cross y. There are
 * 24 lawful ones. */
bool imu_cal_orientation_is_lawful(uint8_t orientation);

/* Turn one vector from the part's axes to the board's, where it lies; a lawful orientation. What
 * -32768 would turn into is limited to 32767. */
void imu_cal_turn(uint8_t orientation, int16_t vector_b_counts[3]);

#endif
