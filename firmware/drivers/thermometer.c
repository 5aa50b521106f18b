/* SPDX-License-Identifier: MIT */
#include "thermometer.h"

#include "mpu6050.h"
#include "mpu6050_registers.h"
#include "twi.h"

/* The transfer under way. */
enum { NONE, WAKE, LOOK, READ };

static uint8_t step;
static uint8_t buffer[2];

static void go(uint8_t next_step)
{
    step      = next_step;
    buffer[0] = MPU6050_CLOCK_GYRO_X; /* where it is read, this goes nowhere */
    twi_ready((uint8_t)(MPU6050_ADDRESS << 1 | (next_step != WAKE)),
              next_step == READ ? MPU6050_TEMP_OUT_H : MPU6050_PWR_MGMT_1, buffer,
              next_step == READ ? 2U : 1U);
    twi_go();
}

void thermometer_init(void)
{
    twi_init();
}

void thermometer_ask(uint32_t now_us)
{
    (void)now_us;
    if (step == NONE) { go(LOOK); }
}

thermometer_status_t thermometer_poll(int16_t *centi, uint32_t now_us)
{
    const uint8_t done = step;

    if (done == NONE) { return THERMOMETER_NOTHING; }
    const uint8_t status = twi_poll(twi_time(now_us));
    if (status == TWI_BUSY) { return THERMOMETER_NOTHING; }
    step = NONE;
    if (status != TWI_IDLE) { return THERMOMETER_MISSING; }
    if (done == READ) {
        *centi = mpu6050_temperature_centi((int16_t)((uint16_t)buffer[0] << 8 | buffer[1]));
        return THERMOMETER_READING;
    }
    if (done == LOOK) { go(buffer[0] == MPU6050_CLOCK_GYRO_X ? READ : WAKE); }
    return THERMOMETER_NOTHING;
}
