/* SPDX-License-Identifier: MIT */
#include "runner_imu.h"

#include "imu_cal.h"
#include "rest.h"

#include <string.h>

enum {
    OP_IMU_CAL_INIT        = 'i', /* imu_cal_config_t as the chip lays it out -> accepted u8 */
    OP_IMU_CAL_TEMPERATURE = 't', /* slope 3 i16, warmth i16 -> offset 3 i16 */
    OP_IMU_CAL_APPLY       = 'I', /* n x raw 3 i16 -> n x calibrated 3 i16 */
    OP_IMU_CAL_CLIPPED     = 'j', /* -> u16 */
    OP_IMU_CAL_TURN        = 'o', /* orientation u8, 3 i16 -> lawful u8, turned 3 i16 */
    OP_REST_INIT           = 'r', /* rest_config_t -> accepted u8 */
    OP_REST_UPDATE         = 'R', /* n x gyro 3 i16, acc 3 i16 -> n x flags u8, bias 3 i32 */
    OP_REST_COUNTS         = 's', /* -> rejected u16, implausible u16 */
    VECTOR_BYTES           = 6,
    SAMPLE_BYTES           = 2 * VECTOR_BYTES,
    SAMPLES_MAX            = 18
};

static imu_cal_config_t cal_config;
static imu_cal_t        cal;
static rest_config_t    rest_config;
static rest_t           rest;

static uint8_t init_cal(uint8_t buffer[])
{
    memcpy(&cal_config, buffer, sizeof cal_config);
    buffer[0] = imu_cal_is_lawful(&cal_config);
    if (buffer[0]) { imu_cal_init(&cal, &cal_config); }
    return 1;
}

static uint8_t apply_cal(uint8_t buffer[], uint8_t len)
{
    for (uint8_t at = 0; at < len; at = (uint8_t)(at + VECTOR_BYTES)) {
        int16_t vector[3];
        memcpy(vector, &buffer[at], sizeof vector);
        imu_cal_apply(&cal, vector);
        memcpy(&buffer[at], vector, sizeof vector);
    }
    return len;
}

static uint8_t warm_cal(uint8_t buffer[])
{
    imu_cal_config_t warm;
    int16_t          slope[3], warmth;
    memcpy(slope, buffer, sizeof slope);
    memcpy(&warmth, &buffer[sizeof slope], sizeof warmth);
    imu_cal_at_temperature(&cal_config, slope, warmth, &warm);
    memcpy(buffer, warm.offset_q3, sizeof warm.offset_q3);
    return sizeof warm.offset_q3;
}

static uint8_t turn_cal(uint8_t buffer[])
{
    const uint8_t orientation = buffer[0];
    int16_t       vector[3];
    memcpy(vector, &buffer[1], sizeof vector);
    buffer[0] = imu_cal_orientation_is_lawful(orientation);
    if (buffer[0]) { imu_cal_turn(orientation, vector); }
    memcpy(&buffer[1], vector, sizeof vector);
    return 1 + sizeof vector;
}

static uint8_t init_rest(uint8_t buffer[])
{
    memcpy(&rest_config, buffer, sizeof rest_config);
    buffer[0] = rest_is_lawful(&rest_config);
    if (buffer[0]) { rest_init(&rest, &rest_config); }
    return 1;
}

static uint8_t update_rest(uint8_t buffer[], uint8_t len)
{
    uint8_t samples[SAMPLES_MAX * SAMPLE_BYTES]; /* the reply is longer than the request */
    uint8_t reply = 0;

    memcpy(samples, buffer, len); /* len <= sizeof samples: the host keeps to it */
    for (uint8_t at = 0; at < len; at = (uint8_t)(at + SAMPLE_BYTES)) {
        int16_t gyro[3], acc[3];
        memcpy(gyro, &samples[at], sizeof gyro);
        memcpy(acc, &samples[at + VECTOR_BYTES], sizeof acc);
        buffer[reply++] = rest_update(&rest, gyro, acc);
        memcpy(&buffer[reply], rest.bias_q16, sizeof rest.bias_q16);
        reply = (uint8_t)(reply + sizeof rest.bias_q16);
    }
    return reply;
}

uint8_t runner_imu_serve(uint8_t op, uint8_t buffer[], uint8_t len)
{
    switch (op) {
    case OP_IMU_CAL_INIT: return init_cal(buffer);
    case OP_IMU_CAL_TEMPERATURE: return warm_cal(buffer);
    case OP_IMU_CAL_APPLY: return apply_cal(buffer, len);
    case OP_IMU_CAL_CLIPPED: memcpy(buffer, &cal.clipped, sizeof cal.clipped); return 2;
    case OP_IMU_CAL_TURN: return turn_cal(buffer);
    case OP_REST_INIT: return init_rest(buffer);
    case OP_REST_UPDATE: return update_rest(buffer, len);
    case OP_REST_COUNTS:
        memcpy(buffer, &rest.rejected, 2);
        memcpy(&buffer[2], &rest.implausible, 2);
        return 4;
    default: return 0;
    }
}
