/* SPDX-License-Identifier: MIT */
/* mpu6050_motion - samples of the MPU-6050: acceleration, temperature and rates of one instant.
 *
 * Model     one engine of steps, each a transfer of twi: who is it (register 0x75); three writes
 *           that set it up; 35 ms of settling (product specification rev. 3.4, p. 12: gyroscope
 *           start-up 30 ms); then a burst of 14 bytes whenever data are ready. The next burst lies
 *           ready on the bus, so that the interrupt that tells of data only begins it. Every eighth
 *           one is followed by a look at ACCEL_CONFIG: another value than was written there
 *           means that the part was reset, and it is set up anew; so does a burst of zeros, which
 *           is what a reset leaves (register map, p. 9)
 * Pacing    INT at D4 tells that data are ready. Each of its edges puts Timer1's compare A off by a
 *           period and 128 us; where no edge comes (boards wired with four wires), the compare
 *           fires and paces in its stead at the nominal period, until edges come again
 * Formats   counts, int16, as the part has them, axes of the part; acceleration 2048 a g (+-16 g),
 *           rates 16.4 a deg/s (+-2000 deg/s), temperature as mpu6050_temperature_centi takes it
 *           device_us: when data were ready; paced by the timer, 128 us before they were asked for
 * Modes     mpu6050_mode_t. 500 Hz with DLPF 2 (98 Hz, 2.8 ms), all others 1 kHz with DLPF 1
 *           (188 Hz, 1.9 ms). Self-test: +-250 deg/s and +-8 g, without and with excitement. Trim:
 *           what a sample holds are registers 0x0D..0x1A, the trim codes first
 * Guests    others may use the bus between two bursts: mpu6050_lend
 * Bad data  a part that does not answer is absent: it is asked again every fifth of a second, and
 *           set up when it answers. A burst that cannot be begun yet waits; one more is not made
 *           and counted in `overruns`
 * Context   main loop; both interrupts are the driver's own.  Cost: firmware/budget.toml
 */
#ifndef MPU6050_MOTION_H
#define MPU6050_MOTION_H

#include <stdbool.h>
#include <stdint.h>

#include "mpu6050.h"

typedef enum {
    MPU6050_OFF,
    MPU6050_500HZ,
    MPU6050_1KHZ,
    MPU6050_SELF_TEST_OFF,
    MPU6050_SELF_TEST_ON,
    MPU6050_TRIM
} mpu6050_mode_t;

/* In the order of the part's registers. */
typedef struct {
    int16_t  acc_b_counts[3];
    int16_t  temp_counts;
    int16_t  gyro_b_counts[3];
    uint32_t device_us;
} mpu6050_sample_t;

/* Take the bus and begin, or begin anew, in that mode; OFF lets the bus go. */
void mpu6050_motion_start(uint8_t mode);

/* Go on; true: the sample is the next one. */
bool mpu6050_motion_poll(mpu6050_sample_t *sample, uint32_t now_us);

/* Ask for the bus for a transfer of 0.3 ms at the most; true: it is the guest's, who gives it back
 * when that has ended, whatever its end. */
bool mpu6050_lend(void);
bool mpu6050_is_lent(void);
void mpu6050_give_back(void);

#endif
