/* SPDX-License-Identifier: MIT */
#include "attitude.h"

#include "counter.h"
#include "health.h"
#include "imu_cal.h"
#include "magnetometer.h"
#include "mahony.h"
#include "mahony_configs.h"
#include "messages.h"
#include "mpu6050_motion.h"
#include "port_outline.h"
#include "port_reach.h"
#include "rest.h"
#include "rest_configs.h"
#include "setup.h"
#include "telemetry.h"
#include "ticks.h"
#include "twi.h"
#include "zupt.h"
#include "zupt_configs.h"
#include "zupt_gru.h"

#include <avr/pgmspace.h>
#include <stddef.h>
#include <string.h>

enum { AXES = 3, GAP_MAX_US = 50000, LOST = UINT16_MAX };

_Static_assert((int)REST_AT_REST == (int)MESSAGES_ATTITUDE_FLAG_REST &&
                   (int)REST_BIAS_KNOWN == (int)MESSAGES_ATTITUDE_FLAG_BIAS_KNOWN,
               "attitude_flag in messages.toml");
_Static_assert((int)MPU6050_ABSENT == (int)MESSAGES_IMU_STATE_ABSENT &&
                   (int)MPU6050_RUNNING == (int)MESSAGES_IMU_STATE_RUNNING,
               "imu_state in messages.toml");

enum { ACC, GYRO, MAG, SENSORS };

/* What is looked at often comes first, where one instruction reaches it. */
typedef struct {
    uint32_t        previous_us; /* of the last sample */
    uint32_t        samples;
    uint16_t        number; /* of the last sample, lost ones counted */
    uint16_t        missed;
    int16_t         temp_counts;
    uint8_t         left;                 /* samples until the next ATTITUDE */
    uint8_t         events;               /* since the last one */
    uint8_t         flags;                /* of rest */
    uint8_t         is_still;             /* of zupt or zupt_gru */
    bool            is_running;           /* samples have come since the part was last away */
    bool            has_field;            /* field_b_counts is one */
    bool            field_is_new;         /* field_b_counts waits for the next sample */
    int16_t         field_b_counts[AXES]; /* calibrated, once it is not new any more */
    imu_cal_t       cal[SENSORS];
    zupt_t          zupt;
    zupt_gru_t      zupt_gru;
    rest_t          rest;
    mahony_t        mahony;
    rest_config_t   rest_config;
    mahony_config_t mahony_config;
} attitude_t;

static attitude_t attitude;

static bool is_calibrating(void)
{
    return setup.imu_mode > SETTINGS_IMU_MODE_HZ_1000;
}

/* Calibrations stand one behind another in the settings. */
static const imu_cal_config_t *config_of(uint8_t sensor)
{
    _Static_assert(
        offsetof(settings_t, gyro) - offsetof(settings_t, acc) == GYRO * sizeof(imu_cal_config_t) &&
            offsetof(settings_t, mag) - offsetof(settings_t, acc) == MAG * sizeof(imu_cal_config_t),
        "acc, gyro, mag");
    return (const imu_cal_config_t *)((const uint8_t *)&setup + offsetof(settings_t, acc)) + sensor;
}

/* What a range cannot say; every value within its range makes a lawful imu_cal. */
static bool is_lawful(void)
{
    return imu_cal_orientation_is_lawful(setup.imu_orientation) &&
           imu_cal_orientation_is_lawful(setup.mag_orientation);
}

PORT_OUTLINE bool attitude_setup(void)
{
    attitude_t *const it       = &attitude;
    const bool        is_1_khz = setup.imu_mode == SETTINGS_IMU_MODE_HZ_1000;

    if (!is_lawful()) { return false; }
    memcpy_P(&it->rest_config, is_1_khz ? &rest_1000hz : &rest_500hz, sizeof it->rest_config);
    memcpy_P(&it->mahony_config, is_1_khz ? &mahony_1000hz : &mahony_500hz,
             sizeof it->mahony_config);
    for (uint8_t sensor = 0; sensor < SENSORS; sensor++) {
        imu_cal_init(&it->cal[sensor], config_of(sensor));
    }
    rest_init(&it->rest, &it->rest_config);
    mahony_init(&it->mahony, &it->mahony_config);
    zupt_choose(PORT_REACH(&it->zupt), setup.imu_zupt,
                is_1_khz ? ZUPT_RATE_1000HZ : ZUPT_RATE_500HZ);
    zupt_gru_init(&it->zupt_gru, is_1_khz ? 1U : 2U);
    it->number     = 0;
    it->is_running = false;
    it->left       = 1;
    health_note_one(MESSAGES_FAULT_FLAG_IMU_LOST, false);
    mpu6050_motion_start(setup.imu_mode);
    return true;
}

bool attitude_setup_key(uint8_t key)
{
    const bool is_looked_up = key == SETTINGS_KEY_IMU_EVERY ||
                              key == SETTINGS_KEY_IMU_TILT_LIMIT_MRAD ||
                              key == SETTINGS_KEY_IMU_LAMP || key == SETTINGS_KEY_UART_BAUD;

    return is_looked_up || attitude_setup();
}

/* How many samples are missing before this one; LOST: so many that none can be bridged. */
static uint16_t take_time(attitude_t *it, uint32_t device_us)
{
    const uint16_t period_us   = setup.imu_mode == SETTINGS_IMU_MODE_HZ_1000 ? 1000U : 2000U;
    const uint32_t interval_us = device_us - it->previous_us;
    uint16_t       left_us     = (uint16_t)interval_us;
    uint16_t       missed      = 0;

    it->previous_us = device_us;
    if (!it->is_running || interval_us > GAP_MAX_US) { return LOST; }
    for (; left_us > period_us + period_us / 2U; left_us -= period_us) { missed++; }
    return missed;
}

/* What there was and what comes are not neighbours. */
static void bridge(attitude_t *it, uint16_t missed)
{
    if (missed == LOST) {
        health_note_one(MESSAGES_FAULT_FLAG_IMU_LOST, false);
    } else {
        counter_add(&it->missed, missed);
        it->number = (uint16_t)(it->number + missed);
        it->events |= MESSAGES_ATTITUDE_FLAG_GAP;
    }
    mahony_gap(&it->mahony, missed);
    rest_interrupt(&it->rest);
    zupt_interrupt(&it->zupt);
    zupt_gru_interrupt(&it->zupt_gru);
}

static PORT_OUTLINE void calibrate(imu_cal_t *cal, uint8_t orientation,
                                   int16_t vector_b_counts[AXES])
{
    imu_cal_apply(cal, vector_b_counts);
    imu_cal_turn(orientation, vector_b_counts);
}

static void take_field(attitude_t *it)
{
    messages_mag_t mag;

    mag.sample = it->number;
    memcpy(&mag.x_counts, it->field_b_counts, sizeof it->field_b_counts);
    telemetry_stream(MESSAGES_STREAM_FLAG_IMU, MESSAGES_MAG_ID, it->previous_us, &mag, sizeof mag);
    calibrate(&it->cal[MAG], setup.mag_orientation, it->field_b_counts);
    it->field_is_new = false;
    it->has_field    = true;
}

/* The sample becomes calibrated, in the board's axes. */
static void run_chain(attitude_t *it, mpu6050_sample_t *sample)
{
    int16_t *const acc_b_counts = sample->acc_b_counts, *const gyro_b_counts =
                                                            sample->gyro_b_counts;

    calibrate(&it->cal[ACC], setup.imu_orientation, acc_b_counts);
    calibrate(&it->cal[GYRO], setup.imu_orientation, gyro_b_counts);
    if (it->mahony.ramp_left > MAHONY_RAMP_LEN) { it->events |= MESSAGES_ATTITUDE_FLAG_RESTARTED; }
    it->flags = rest_update(&it->rest, gyro_b_counts, acc_b_counts);
    mahony_update(&it->mahony, gyro_b_counts, acc_b_counts, it->rest.bias_q16);
    if ((it->mahony.step.flags & MAHONY_RAILED) != 0U) {
        it->events |= MESSAGES_ATTITUDE_FLAG_RAILED;
    }
    if (it->field_is_new) { take_field(it); }
    if (it->has_field) { mahony_update_mag(&it->mahony, it->field_b_counts); }
    it->is_still = setup.imu_zupt == SETTINGS_ZUPT_GRU
                       ? zupt_gru_update(&it->zupt_gru, gyro_b_counts, acc_b_counts)
                       : zupt_update(PORT_REACH(&it->zupt), gyro_b_counts, acc_b_counts);
}

static uint8_t flags_now(const attitude_t *it)
{
    uint8_t flags = it->flags | it->events;

    if (it->is_still) { flags |= MESSAGES_ATTITUDE_FLAG_STILL; }
    const mahony_mag_t *const mag = PORT_REACH(&it->mahony.mag);
    if (it->has_field && mag->raised_q21 != 0U) {
        flags |= MESSAGES_ATTITUDE_FLAG_HEADING;
        if (mag->rejected != 0U) { flags |= MESSAGES_ATTITUDE_FLAG_DISTURBED; }
    }
    return flags;
}

static void tell_raw(const attitude_t *it, const mpu6050_sample_t *sample)
{
    messages_imu_t message;

    message.sample = it->number;
    memcpy(&message.acc_x_counts, sample, offsetof(mpu6050_sample_t, device_us));
    telemetry_stream(MESSAGES_STREAM_FLAG_IMU, MESSAGES_IMU_ID, sample->device_us, &message,
                     sizeof message);
}

static void tell(attitude_t *it, uint32_t device_us)
{
    messages_attitude_t message;

    message.sample = it->number;
    message.flags  = flags_now(it);
    memcpy(&message.quat_w_q30, it->mahony.step.quat_wb_q30, sizeof it->mahony.step.quat_wb_q30);
    it->events = 0;
    telemetry_stream(MESSAGES_STREAM_FLAG_ATTITUDE, MESSAGES_ATTITUDE_ID, device_us, &message,
                     sizeof message);
}

static void take(attitude_t *it, mpu6050_sample_t *sample)
{
    const uint16_t missed = take_time(it, sample->device_us);
    const bool     tells  = --it->left == 0U;

    if (missed != 0U) { bridge(it, missed); }
    it->is_running = true;
    it->samples++;
    it->number++;
    it->temp_counts = sample->temp_counts;
    if (tells) {
        it->left = setup.imu_every;
        tell_raw(it, sample);
    }
    if (is_calibrating()) { return; }
    run_chain(it, sample);
    if (tells) { tell(it, sample->device_us); }
}

static PORT_OUTLINE void poll_field(attitude_t *it)
{
    if (magnetometer_poll(it->field_b_counts, ticks_device_us())) { it->field_is_new = true; }
    if (magnetometer_kind() == MESSAGES_MAG_KIND_NONE) { it->has_field = false; }
}

void attitude_poll(void)
{
    attitude_t *const it = &attitude;
    mpu6050_sample_t  sample;

    if (mpu6050_motion_poll(&sample, ticks_device_us())) {
        poll_field(it); /* between this burst and the next, before work fills the time */
        take(it, &sample);
    }
    poll_field(it);
    if (it->is_running && mpu6050_state() != MPU6050_RUNNING) {
        it->is_running = false;
        it->is_still   = false;
        it->flags &= (uint8_t)~REST_AT_REST;
        health_note_one(MESSAGES_FAULT_FLAG_IMU_LOST, true);
    }
}

/* Sine of the tilt about either level axis against the limit: 16.384 counts a mrad. */
static bool is_askew(const int16_t up_b_q14[AXES])
{
    const uint16_t most = (uint16_t)(setup.imu_tilt_limit_mrad * 131U) >> 3;

    if (most == 0U) { return false; }
    for (uint8_t axis = 0; axis < 2U; axis++) { /* one comparison modulo 2^16 */
        if ((uint16_t)((uint16_t)up_b_q14[axis] + most) > 2U * most) { return true; }
    }
    return false;
}

_Static_assert(sizeof(messages_imu_status_t) == MESSAGES_IMU_STATUS_LEN &&
                   sizeof(messages_attitude_t) == MESSAGES_ATTITUDE_LEN &&
                   sizeof(messages_imu_t) == MESSAGES_IMU_LEN &&
                   sizeof(messages_mag_t) == MESSAGES_MAG_LEN,
               "no padding");
_Static_assert(sizeof(mahony_counts_t) == offsetof(messages_imu_status_t, bias_x_q16) -
                                              offsetof(messages_imu_status_t, acc_zero) &&
                   sizeof(mpu6050_counters_t) == offsetof(messages_imu_status_t, clipped) -
                                                     offsetof(messages_imu_status_t, overruns),
               "counters stand in IMU_STATUS as their owners have them");

void attitude_tick(void)
{
    const attitude_t *const  it       = &attitude;
    const mpu6050_counters_t counters = mpu6050_counters();
    messages_imu_status_t    status;

    if (it->samples == 0U) { return; }
    status.state          = (uint8_t)mpu6050_state();
    status.identity       = mpu6050_identity();
    status.mag_kind       = magnetometer_kind();
    status.bus_recoveries = twi_recoveries;
    status.samples        = it->samples;
    status.missed         = it->missed;
    memcpy(&status.overruns, &counters, sizeof counters);
    status.clipped       = (uint16_t)(it->cal[ACC].clipped + it->cal[GYRO].clipped);
    status.rest_rejected = it->rest.rejected;
    memcpy(&status.acc_zero, &it->mahony.counts, sizeof it->mahony.counts);
    memcpy(&status.bias_x_q16, it->rest.bias_q16, sizeof it->rest.bias_q16);
    status.temp_counts = it->temp_counts;
    mahony_up(&it->mahony, &status.up_x_q14);
    if ((it->flags & REST_AT_REST) != 0U || setup.imu_tilt_limit_mrad == 0U) {
        health_note_one(MESSAGES_FAULT_FLAG_ASKEW, is_askew(&status.up_x_q14));
    }
    telemetry_stream(MESSAGES_STREAM_FLAG_STATUS, MESSAGES_IMU_STATUS_ID, it->previous_us, &status,
                     sizeof status);
}

bool attitude_is_still(void)
{
    return attitude.is_still;
}

bool attitude_temperature(int16_t *centi)
{
    *centi = mpu6050_temperature_centi(attitude.temp_counts);
    return attitude.is_running && !is_calibrating();
}
