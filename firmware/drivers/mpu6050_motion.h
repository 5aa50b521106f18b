/* SPDX-License-Identifier: MIT */
/* mpu6050_motion - samples of the MPU-6050: acceleration, temperature and rates of one instant.
 *
 * Model     whoever knows that data are ready (the part's INT line, or a timer) calls
 *           mpu6050_motion_due; the burst is read meanwhile and handed on by mpu6050_motion_poll.
 *           Two buffers: one is read while the other is filled
 * Formats   counts, int16, as the part has them, axes of the part; acceleration 2048 a g (+-16 g),
 *           rates 16.4 a deg/s (+-2000 deg/s), temperature as mpu6050_temperature_centi takes it
 *           device_us: when data were ready
 * Setups    500 Hz with DLPF 2 (98 Hz, 2.8 ms), 1 kHz with DLPF 1 (188 Hz, 1.9 ms); the part read
 *           back as guard every 16 ms, so that a reset is seen within 20 ms
 * Self-test answers of the part to its own test, in counts at +-250 deg/s and +-8 g; each must lie
 *           within 14 % of what its trim codes promise (PS-MPU-6000A-00 rev. 3.4, p. 12; register
 *           map rev. 4.2, pp. 9-12). An axis without a code was never trimmed: passes
 * Bad data  as mpu6050.h
 * Context   main loop; mpu6050_motion_due from an interrupt handler.  Cost: firmware/budget.toml
 */
#ifndef MPU6050_MOTION_H
#define MPU6050_MOTION_H

#include <stdbool.h>
#include <stdint.h>

#include "mpu6050.h"

/* In the order of the part's registers. */
typedef struct {
    int16_t  acc_b_counts[3];
    int16_t  temp_counts;
    int16_t  gyro_b_counts[3];
    uint32_t device_us;
} mpu6050_sample_t;

extern const mpu6050_setup_t mpu6050_motion_500hz;
extern const mpu6050_setup_t mpu6050_motion_1khz;
extern const mpu6050_setup_t mpu6050_self_test_off; /* 1 kHz, +-250 deg/s, +-8 g */
extern const mpu6050_setup_t mpu6050_self_test_on;  /* the same, excited */

/* Data are ready since now. */
void mpu6050_motion_due(uint32_t now_us);

/* Go on; true: the sample is the next one. */
bool mpu6050_motion_poll(mpu6050_sample_t *sample, uint32_t now_us);

/* trim: SELF_TEST_X..SELF_TEST_A, registers 0x0D..0x10.  answer: what excitement added, in the
 * order of mpu6050_sample_t; the temperature's is not looked at. */
bool mpu6050_self_test_passes(const uint8_t trim[4], const int16_t answer_counts[7]);

#endif
