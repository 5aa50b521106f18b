/* SPDX-License-Identifier: MIT */
/* mpu6050 - the IMU MPU-6050 at address 0x68 and its siblings: what all who ask it share.
 *
 * Model     InvenSense RM-MPU-6000A-00 rev. 4.2, PS-MPU-6000A-00 rev. 3.4; samples come from
 *           mpu6050_motion, the temperature alone from thermometer
 * Siblings  WHO_AM_I other than 0x68 (0x98, 0x72, 0x70 have been seen) is told by mpu6050_identity
 *           and served alike
 */
#ifndef MPU6050_H
#define MPU6050_H

#include <stdbool.h>
#include <stdint.h>

enum { MPU6050_ADDRESS = 0x68, MPU6050_WHO_AM_I = 0x68 };

typedef enum {
    MPU6050_ABSENT,   /* nobody answers, the bus is stuck, or it is not asked */
    MPU6050_STARTING, /* answers; being set up */
    MPU6050_RUNNING
} mpu6050_state_t;

/* Since reset; each stops at its maximum. */
typedef struct {
    volatile uint16_t overruns; /* data that were ready while a burst waited: never read */
    uint16_t          losses;   /* the part stopped answering, or was found reset */
} mpu6050_counters_t;

mpu6050_state_t    mpu6050_state(void);
uint8_t            mpu6050_identity(void); /* WHO_AM_I; 0: it never answered */
mpu6050_counters_t mpu6050_counters(void);

/* 1/100 degC of TEMP_OUT: raw / 3.4 + 3653, register map rev. 4.2, p. 30. */
int16_t mpu6050_temperature_centi(int16_t temp_counts);

#endif
