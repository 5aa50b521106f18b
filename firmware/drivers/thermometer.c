/* SPDX-License-Identifier: MIT */
#include "thermometer.h"

#include "mpu6050.h"
#include "mpu6050_registers.h"
#include "twi.h"

/* The transfer under way, by the number of bytes that it reads, and one. */
enum { NONE, WAKE, LOOK, READ };

static uint8_t step;
static uint8_t buffer[2];

static void go(uint8_t next_step, uint32_t now_us)
{
    step      = next_step;
    buffer[0] = next_step == READ ? MPU6050_TEMP_OUT_H : MPU6050_PWR_MGMT_1;
    buffer[1] = MPU6050_CLOCK_GYRO_X; /* where it is read, this goes nowhere */
    twi_begin(MPU6050_ADDRESS, buffer, next_step == WAKE ? 2U : 1U, (uint8_t)(next_step - WAKE),
              now_us);
}

void thermometer_init(void)
{
    twi_init();
}

void thermometer_ask(uint32_t now_us)
{
    if (step == NONE) { go(LOOK, now_us); }
}

thermometer_status_t thermometer_poll(int16_t *centi, uint32_t now_us)
{
    const uint8_t done   = step;
    const uint8_t status = twi_poll(now_us);

    if (done == NONE || status == TWI_BUSY) { return THERMOMETER_NOTHING; }
    step = NONE;
    if (status != TWI_IDLE) { return THERMOMETER_MISSING; }
    if (done == READ) {
        *centi = mpu6050_temperature_centi(buffer);
        return THERMOMETER_READING;
    }
    if (done == LOOK) { go(buffer[0] == MPU6050_CLOCK_GYRO_X ? READ : WAKE, now_us); }
    return THERMOMETER_NOTHING;
}
