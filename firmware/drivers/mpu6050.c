/* SPDX-License-Identifier: MIT */
#include "mpu6050.h"

int16_t mpu6050_temperature_centi(int16_t temp_counts)
{
    /* 1 / 3.4 = 19275 / 2^16, short by 1.5e-5 of it */
    return (int16_t)(((temp_counts * 19275L + 0x8000L) >> 16) + 3653);
}
