/* SPDX-License-Identifier: GPL-3.0-or-later */
/* parts - the parts on the two-wire bus: an MPU-6050, a magnetometer; fitted when told to.
 *
 * A part that is not plugged in answers to nothing; it starts anew when it is plugged in.
 */
#ifndef PARTS_H
#define PARTS_H

#include "magnetometer.h"
#include "mpu6050.h"

struct uno;

typedef struct {
    mpu6050_t      imu;
    magnetometer_t mag;
    bool           imu_fitted, imu_plugged;
    bool           mag_fitted, mag_plugged;
    uint8_t        int_bit; /* of port D */
} parts_t;

void parts_init(struct uno *uno);
void parts_after_reset(struct uno *uno, bool power);

#endif
