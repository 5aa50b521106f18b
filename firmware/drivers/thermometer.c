/* SPDX-License-Identifier: MIT */
#include "thermometer.h"

#include "mpu6050.h"
#include "mpu6050_registers.h"
#include "twi.h"

/* The transfer under way, in order. */
enum { NONE, LOOK, READ, WAKE };

static uint8_t step;
static uint8_t buffer[2];

static void go(uint8_t next_step, uint8_t reg, uint8_t read_len, uint32_t now_us)
{
    step      = next_step;
    buffer[0] = reg;
    buffer[1] = MPU6050_CLOCK_GYRO_X; /* where it is read, this goes nowhere */
    twi_begin(MPU6050_ADDRESS, buffer, read_len == 0U ? 2U : 1U, read_len, now_us);
}

void thermometer_init(void)
{
    twi_init();
}

void thermometer_ask(uint32_t now_us)
{
    if (step == NONE) { go(LOOK, MPU6050_PWR_MGMT_1, 1, now_us); }
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
    if (done == LOOK) {
        if (buffer[0] == MPU6050_CLOCK_GYRO_X) {
            go(READ, MPU6050_TEMP_OUT_H, 2, now_us);
        } else {
            go(WAKE, MPU6050_PWR_MGMT_1, 0, now_us);
        }
    }
    return THERMOMETER_NOTHING;
}
