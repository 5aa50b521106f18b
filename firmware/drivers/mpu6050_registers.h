/* SPDX-License-Identifier: MIT */
/* mpu6050_registers - those in use, by their names in RM-MPU-6000A-00 rev. 4.2, pp. 6-9. */
#ifndef MPU6050_REGISTERS_H
#define MPU6050_REGISTERS_H

enum {
    MPU6050_SELF_TEST_X  = 0x0D,
    MPU6050_SMPLRT_DIV   = 0x19,
    MPU6050_CONFIG       = 0x1A,
    MPU6050_GYRO_CONFIG  = 0x1B,
    MPU6050_ACCEL_CONFIG = 0x1C,
    MPU6050_INT_PIN_CFG  = 0x37,
    MPU6050_INT_ENABLE   = 0x38,
    MPU6050_ACCEL_XOUT_H = 0x3B,
    MPU6050_TEMP_OUT_H   = 0x41,
    MPU6050_PWR_MGMT_1   = 0x6B,
    MPU6050_WHO_AM_I_REG = 0x75,

    MPU6050_CLOCK_GYRO_X = 0x01 /* PWR_MGMT_1: awake, clocked by the gyroscope, as advised there */
};

#endif
