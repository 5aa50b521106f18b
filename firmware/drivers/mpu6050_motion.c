/* SPDX-License-Identifier: MIT */
#include "mpu6050_motion.h"

#include "mpu6050_registers.h"

#include <avr/pgmspace.h>
#include <string.h>

enum { WORDS = 7, BURST = 2 * WORDS, SLOTS = 2 };

enum {
    RANGE_MOST    = 0x18, /* +-2000 deg/s, +-16 g */
    RANGE_8_G     = 0x10,
    EXCITED       = 0xE0,
    PULSE_50_US   = 0x00, /* INT_PIN_CFG: active high, 50 us */
    DATA_READY_EN = 0x01
};

/* The guard, the last pair, is one that a reset changes. */
#define MOTION(divider, dlpf, every)                                                        \
    {                                                                                       \
        .first_register = MPU6050_ACCEL_XOUT_H, .burst_len = BURST, .guard_every = (every), \
        .pair_count = 7, .pairs = {                                                         \
            {MPU6050_PWR_MGMT_1, MPU6050_CLOCK_GYRO_X},                                     \
            {MPU6050_SMPLRT_DIV, (divider)},                                                \
            {MPU6050_CONFIG, (dlpf)},                                                       \
            {MPU6050_GYRO_CONFIG, RANGE_MOST},                                              \
            {MPU6050_INT_PIN_CFG, PULSE_50_US},                                             \
            {MPU6050_INT_ENABLE, DATA_READY_EN},                                            \
            {MPU6050_ACCEL_CONFIG, RANGE_MOST},                                             \
        }                                                                                   \
    }
#define SELF_TEST(excited)                                                             \
    {                                                                                  \
        .first_register = MPU6050_ACCEL_XOUT_H, .burst_len = BURST, .guard_every = 16, \
        .pair_count = 6, .pairs = {                                                    \
            {MPU6050_PWR_MGMT_1, MPU6050_CLOCK_GYRO_X},                                \
            {MPU6050_SMPLRT_DIV, 0},                                                   \
            {MPU6050_CONFIG, 1},                                                       \
            {MPU6050_GYRO_CONFIG, (excited)},                                          \
            {MPU6050_INT_ENABLE, DATA_READY_EN},                                       \
            {MPU6050_ACCEL_CONFIG, RANGE_8_G | (excited)},                             \
        }                                                                              \
    }

const mpu6050_setup_t mpu6050_motion_500hz  PROGMEM = MOTION(1, 2, 8);
const mpu6050_setup_t mpu6050_motion_1khz   PROGMEM = MOTION(0, 1, 16);
const mpu6050_setup_t mpu6050_self_test_off PROGMEM = SELF_TEST(0);
const mpu6050_setup_t mpu6050_self_test_on  PROGMEM = SELF_TEST(EXCITED);

static uint8_t           bursts[SLOTS][BURST]; /* the bus fills, poll reads */
static volatile uint32_t due_us[SLOTS];        /* due writes before the bus fills, poll reads */
static volatile uint8_t  next_slot;            /* due writes: where the next burst goes */
static uint8_t           read_slot;            /* where the next one comes from */

void mpu6050_motion_due(uint32_t now_us)
{
    const uint8_t slot = next_slot;

    if (mpu6050_request(bursts[slot], now_us)) {
        due_us[slot] = now_us;
        next_slot    = slot ^ 1U;
    }
}

bool mpu6050_motion_poll(mpu6050_sample_t *sample, uint32_t now_us)
{
    const bool come = mpu6050_poll(now_us);

    if (mpu6050_state() != MPU6050_RUNNING) { read_slot = next_slot; }
    if (!come) { return false; }
    const uint8_t *byte = bursts[read_slot];
    int16_t        words[WORDS];
    for (uint8_t at = 0; at < WORDS; at++) {
        words[at] = (int16_t)(((uint16_t)byte[0] << 8) | byte[1]);
        byte += 2;
    }
    memcpy(sample->acc_b_counts, &words[0], sizeof sample->acc_b_counts);
    memcpy(sample->gyro_b_counts, &words[4], sizeof sample->gyro_b_counts);
    sample->temp_counts = words[3];
    sample->device_us   = due_us[read_slot];
    read_slot ^= 1U;
    return true;
}

/* first * growth^(code - 1), growth = 1 + of_65536 / 2^16: within 0.3 % */
static uint16_t grown(uint16_t first, uint16_t of_65536, uint8_t code)
{
    for (; code > 1U; code--) { first += (uint16_t)(((uint32_t)first * of_65536 + 32768UL) >> 16); }
    return first;
}

static bool axis_passes(uint8_t code, int16_t answer, uint16_t first, uint16_t of_65536)
{
    if (code == 0U) { return true; }
    const uint16_t promised = grown(first, of_65536, code);                   /* <= 12 700 */
    const uint16_t margin   = (uint16_t)(((uint32_t)promised * 9175U) >> 16); /* 14 % */

    return answer >= (int16_t)(promised - margin) && answer <= (int16_t)(promised + margin);
}

bool mpu6050_self_test_passes(const uint8_t trim[4], const int16_t answer_counts[WORDS])
{
    uint8_t low_bits = trim[3]; /* two of each accelerometer axis, x uppermost */

    for (uint8_t axis = 0; axis < 3U; axis++) {
        const uint8_t acc_code  = (uint8_t)(((trim[axis] >> 3) & 0x1CU) | ((low_bits >> 4) & 3U));
        const int16_t rate      = answer_counts[4U + axis];
        const int16_t magnitude = axis == 1U ? (int16_t)-rate : rate; /* y answers the other way */

        low_bits = (uint8_t)(low_bits << 2);
        /* 4096 * 0.34, growth (0.92 / 0.34)^(1/30); 25 * 131, growth 1.046 */
        if (!axis_passes(acc_code, answer_counts[axis], 1393, 2211) ||
            !axis_passes(trim[axis] & 0x1FU, magnitude, 3275, 3015)) {
            return false;
        }
    }
    return true;
}
