/* SPDX-License-Identifier: MIT */
/* magnetometer - QMC5883L (address 0x0D) or HMC5883L (0x1E), told apart by where somebody answers.
 *
 * Model     a guest of mpu6050_motion on the bus: three writes set the part to continuous
 *           measurement, then it is read 70 times a second. The writes are made again every second,
 *           so that a part that was reset measures on. QST QMC5883L datasheet 1.0, section 9:
 *           100 Hz, 512 samples a measurement, interrupt off, set and reset as advised. Honeywell
 *           HMC5883L datasheet rev. E, pp. 12-15: 75 Hz, gain of its power-up
 * Formats   counts, int16, axes of the part; QMC5883L 3000 a gauss (+-8 G), HMC5883L 1090 (+-1.3 G)
 * Bad data  a reading with an axis beyond its range, or of zeros, which is what a reset leaves, is
 *           refused: none comes. A part that does not answer is absent; then either address is
 *           asked, in turn, every fifth of a second
 * Context   main loop, right after mpu6050_motion_poll, as long as that is called, and again where
 *           work on a sample has kept the loop: while the guest has the bus no burst begins.
 *           Cost: firmware/budget.toml
 */
#ifndef MAGNETOMETER_H
#define MAGNETOMETER_H

#include <stdbool.h>
#include <stdint.h>

typedef enum { MAGNETOMETER_NONE, MAGNETOMETER_QMC5883L, MAGNETOMETER_HMC5883L } magnetometer_t;

/* Go on, unless mpu6050_motion is off; true: a reading. */
bool magnetometer_poll(int16_t mag_counts[3], uint32_t now_us);

uint8_t magnetometer_kind(void); /* magnetometer_t */

#endif
