/* SPDX-License-Identifier: MIT */
#include "runner_mahony.h"

#include "mahony.h"
#include "rest.h"
#include "rest_configs.h"

#include <avr/pgmspace.h>
#include <string.h>

enum {
    OP_INIT   = '0', /* axes u8, mahony_modes_config_t as the chip lays it out -> accepted u8 */
    OP_UPDATE = '1', /* n x sample_t -> n x result_t */
    OP_COUNTS = '2', /* -> mahony_counts_t */
    OP_ACCELERATION = '3', /* acc 3 i16 -> free of gravity 3 i16 */
    OP_CHAIN_START  = '4', /* rest begins */
    OP_CHAIN        = '5'  /* n x sample_t, the bias from rest: what the budget measures */
};

typedef struct {
    uint16_t gap_samples; /* missing before this one */
    int16_t  gyro[3], acc[3], mag[3];
    int32_t  bias_q16[3];
} sample_t;

typedef struct {
    int32_t quat_wb_q30[4];
    int16_t roll_q13, pitch_q13, yaw_q13;
} result_t;

static mahony_modes_config_t config;
static mahony_modes_t        modes;
static mahony_euler_t        euler;
static rest_config_t         rest_config;
static rest_t                rest;
static uint8_t               axes;

static uint8_t init(uint8_t buffer[])
{
    axes = buffer[0];
    memcpy(&config, &buffer[1], sizeof config);
    buffer[0] = mahony_modes_is_lawful(&config);
    if (buffer[0]) { mahony_modes_init(&modes, &config); }
    memset(&euler, 0, sizeof euler);
    return 1;
}

static uint8_t update(uint8_t buffer[], uint8_t len)
{
    uint8_t reply = 0;

    for (uint8_t at = 0; at < len; at = (uint8_t)(at + sizeof(sample_t))) {
        sample_t sample;
        result_t result;

        memcpy(&sample, &buffer[at], sizeof sample); /* longer than the result: never overtaken */
        if (sample.gap_samples != 0U) { mahony_modes_gap(&modes, sample.gap_samples); }
        mahony_modes_update(&modes, sample.gyro, sample.acc, sample.bias_q16);
        if (axes == 9U) { mahony_update_mag(&modes.mahony, sample.mag); }
        mahony_quaternion(&modes.mahony, result.quat_wb_q30);
        mahony_euler(&modes.mahony, &euler);
        result.roll_q13  = euler.roll_q13;
        result.pitch_q13 = euler.pitch_q13;
        result.yaw_q13   = euler.yaw_q13;
        memcpy(&buffer[reply], &result, sizeof result);
        reply = (uint8_t)(reply + sizeof result);
    }
    return reply;
}

/* A device's whole step, in functions of their own so that their cost can be measured. */

static sample_t sample;

__attribute__((noinline)) static void attitude6(void)
{
    rest_update(&rest, sample.gyro, sample.acc);
    mahony_update(&modes.mahony, sample.gyro, sample.acc, rest.bias_q16);
}

__attribute__((noinline)) static void attitude9(void)
{
    rest_update(&rest, sample.gyro, sample.acc);
    mahony_update(&modes.mahony, sample.gyro, sample.acc, rest.bias_q16);
    mahony_update_mag(&modes.mahony, sample.mag);
}

static uint8_t chain(const uint8_t buffer[], uint8_t len)
{
    for (uint8_t at = 0; at < len; at = (uint8_t)(at + sizeof sample)) {
        memcpy(&sample, &buffer[at], sizeof sample);
        if (axes == 9U) {
            attitude9();
        } else {
            attitude6();
        }
    }
    return 0;
}

static uint8_t start_chain(void)
{
    memcpy_P(&rest_config, &rest_286hz, sizeof rest_config);
    rest_init(&rest, &rest_config);
    return 0;
}

static uint8_t free_acceleration(uint8_t buffer[])
{
    int16_t acc[3], free_b[3];

    memcpy(acc, buffer, sizeof acc);
    mahony_free_acceleration(&modes.mahony, acc, free_b);
    memcpy(buffer, free_b, sizeof free_b);
    return sizeof free_b;
}

uint8_t runner_mahony_serve(uint8_t op, uint8_t buffer[], uint8_t len)
{
    switch (op) {
    case OP_INIT: return init(buffer);
    case OP_UPDATE: return update(buffer, len);
    case OP_COUNTS:
        memcpy(buffer, &modes.mahony.counts, sizeof modes.mahony.counts);
        return sizeof modes.mahony.counts;
    case OP_ACCELERATION: return free_acceleration(buffer);
    case OP_CHAIN_START: return start_chain();
    case OP_CHAIN: return chain(buffer, len);
    default: return 0;
    }
}
