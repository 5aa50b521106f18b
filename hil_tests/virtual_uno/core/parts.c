/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "uno_internal.h"

#include <string.h>

enum { IMU_ADDRESS = 0x68, QMC_ADDRESS = 0x0D, HMC_ADDRESS = 0x1E };

/* --- time --- */

static avr_cycle_count_t imu_due(avr_t *avr, avr_cycle_count_t when, void *param)
{
    mpu6050_t *imu = &((uno_t *)param)->parts.imu;

    (void)when;
    mpu6050_advance(imu, avr->cycle);
    const uint64_t due = mpu6050_next_tick(imu);
    return due == UINT64_MAX ? 0 : due;
}

static avr_cycle_count_t mag_due(avr_t *avr, avr_cycle_count_t when, void *param)
{
    magnetometer_t *mag = &((uno_t *)param)->parts.mag;

    (void)when;
    magnetometer_advance(mag, avr->cycle);
    const uint64_t due = magnetometer_next_tick(mag);
    return due == UINT64_MAX ? 0 : due;
}

static void rearm(uno_t *uno, avr_cycle_timer_t timer, uint64_t due)
{
    const uint64_t now = uno->avr->cycle;

    avr_cycle_timer_cancel(uno->avr, timer, uno);
    if (due == UINT64_MAX) { return; }
    avr_cycle_timer_register(uno->avr, due > now ? due - now : 1U, timer, uno);
}

static void rearm_imu(uno_t *uno)
{
    const parts_t *parts = &uno->parts;

    rearm(uno, imu_due, parts->imu_plugged ? mpu6050_next_tick(&parts->imu) : UINT64_MAX);
}

static void rearm_mag(uno_t *uno)
{
    const parts_t *parts = &uno->parts;

    rearm(uno, mag_due, parts->mag_plugged ? magnetometer_next_tick(&parts->mag) : UINT64_MAX);
}

/* --- on the bus --- */

static bool imu_start(void *ctx, bool reading)
{
    uno_t *uno = ctx;

    if (!uno->parts.imu_plugged) { return false; }
    mpu6050_advance(&uno->parts.imu, uno->avr->cycle);
    const bool acked = mpu6050_start(&uno->parts.imu, reading);
    rearm_imu(uno);
    return acked;
}

static bool imu_write(void *ctx, uint8_t byte)
{
    uno_t *uno = ctx;

    if (!uno->parts.imu_plugged) { return false; }
    mpu6050_advance(&uno->parts.imu, uno->avr->cycle);
    const bool acked = mpu6050_write(&uno->parts.imu, byte);
    rearm_imu(uno);
    return acked;
}

static uint8_t imu_read(void *ctx)
{
    uno_t *uno = ctx;

    if (!uno->parts.imu_plugged) { return 0xFF; }
    mpu6050_advance(&uno->parts.imu, uno->avr->cycle);
    const uint8_t byte = mpu6050_read(&uno->parts.imu);
    rearm_imu(uno);
    return byte;
}

static bool mag_start(void *ctx, bool reading)
{
    uno_t *uno = ctx;

    if (!uno->parts.mag_plugged) { return false; }
    magnetometer_advance(&uno->parts.mag, uno->avr->cycle);
    return magnetometer_start(&uno->parts.mag, reading);
}

static bool mag_write(void *ctx, uint8_t byte)
{
    uno_t *uno = ctx;

    if (!uno->parts.mag_plugged) { return false; }
    magnetometer_advance(&uno->parts.mag, uno->avr->cycle);
    const bool acked = magnetometer_write(&uno->parts.mag, byte);
    rearm_mag(uno);
    return acked;
}

static uint8_t mag_read(void *ctx)
{
    uno_t *uno = ctx;

    if (!uno->parts.mag_plugged) { return 0xFF; }
    magnetometer_advance(&uno->parts.mag, uno->avr->cycle);
    return magnetometer_read(&uno->parts.mag);
}

/* --- signals and the interrupt line --- */

static void imu_signal(void *ctx, const uint64_t *ticks, uint8_t dlpf, double *rows, uint32_t n)
{
    uno_t *uno = ctx;

    uno_part_source(uno->source_ctx, UNO_PART_IMU, ticks, dlpf, rows, n);
}

static void mag_signal(void *ctx, uint64_t tick, double *field)
{
    uno_t *uno = ctx;

    uno_part_source(uno->source_ctx, UNO_PART_MAG, &tick, 0, field, 1);
}

static void int_moved(void *ctx, uint8_t level)
{
    uno_t *uno = ctx;

    if (uno->parts.int_bit < 8U) { pins_drive(uno, uno->parts.int_bit, level); }
}

/* --- the board's side --- */

void parts_init(uno_t *uno)
{
    uno->parts.int_bit = UINT8_MAX;
}

void parts_after_reset(uno_t *uno, bool power)
{
    parts_t       *parts = &uno->parts;
    const uint64_t now   = uno->avr->cycle;

    if (parts->imu_plugged) {
        if (power) { mpu6050_power_on(&parts->imu, now); }
        mpu6050_restate(&parts->imu); /* signals count from the reset */
        int_moved(uno, parts->imu.int_level);
        rearm_imu(uno);
    }
    if (parts->mag_plugged) {
        if (power) { magnetometer_power_on(&parts->mag, now); }
        rearm_mag(uno);
    }
}

/* --- for Python --- */

uint8_t uno_imu_fit(uno_t *uno, const imu_config_t *config)
{
    parts_t   *parts = &uno->parts;
    mpu6050_t *imu   = &parts->imu;

    imu->hz        = UNO_CLOCK_HZ;
    imu->clock_ppm = config->clock_ppm;
    imu->who_am_i  = config->who_am_i;
    memcpy(imu->trim, config->trim, sizeof imu->trim);
    imu->source    = imu_signal;
    imu->int_moved = int_moved;
    imu->ctx       = uno;
    parts->int_bit = config->int_bit;
    if (!parts->imu_fitted) {
        const twi_device_t device = {.ctx     = uno,
                                     .address = IMU_ADDRESS,
                                     .start   = imu_start,
                                     .write   = imu_write,
                                     .read    = imu_read};
        if (!twi_attach(uno, &device)) { return 0; }
        parts->imu_fitted = true;
    }
    uno_imu_plug(uno, 1);
    return 1;
}

void uno_imu_plug(uno_t *uno, uint8_t plugged)
{
    parts_t *parts = &uno->parts;

    parts->imu_plugged = parts->imu_fitted && plugged;
    if (parts->imu_plugged) { mpu6050_power_on(&parts->imu, uno->avr->cycle); }
    if (!parts->imu_plugged && parts->int_bit < 8U) { pins_float(uno, parts->int_bit); }
    rearm_imu(uno);
}

void uno_imu_wire_int(uno_t *uno, uint8_t int_bit)
{
    parts_t *parts = &uno->parts;

    if (parts->int_bit < 8U) { pins_float(uno, parts->int_bit); }
    parts->int_bit = int_bit;
    int_moved(uno, parts->imu.int_level);
}

void uno_imu_set_register(uno_t *uno, uint8_t reg, uint8_t value)
{
    mpu6050_t *imu = &uno->parts.imu;

    mpu6050_advance(imu, uno->avr->cycle);
    mpu6050_start(imu, false);
    mpu6050_write(imu, reg);
    mpu6050_write(imu, value);
    rearm_imu(uno);
}

void uno_imu_restate(uno_t *uno)
{
    mpu6050_restate(&uno->parts.imu);
}

void uno_imu_play(uno_t *uno, const int16_t *rows, uint32_t n)
{
    mpu6050_t *imu = &uno->parts.imu;

    imu->played       = n ? rows : NULL;
    imu->played_count = n;
    imu->played_next  = 0;
    mpu6050_restate(imu);
}

uint32_t uno_imu_played(const uno_t *uno)
{
    return uno->parts.imu.played_next;
}

void uno_imu_registers(const uno_t *uno, uint8_t *regs)
{
    memcpy(regs, uno->parts.imu.regs, MPU6050_REGISTERS);
}

void uno_imu_get_stats(const uno_t *uno, imu_stats_t *stats)
{
    *stats = uno->parts.imu.stats;
}

uint8_t uno_mag_fit(uno_t *uno, uint8_t kind)
{
    parts_t           *parts  = &uno->parts;
    const twi_device_t device = {.ctx     = uno,
                                 .address = kind == UNO_MAG_QMC5883L ? QMC_ADDRESS : HMC_ADDRESS,
                                 .start   = mag_start,
                                 .write   = mag_write,
                                 .read    = mag_read};

    if (parts->mag_fitted || !twi_attach(uno, &device)) { return 0; }
    parts->mag.kind   = kind;
    parts->mag.hz     = UNO_CLOCK_HZ;
    parts->mag.source = mag_signal;
    parts->mag.ctx    = uno;
    parts->mag_fitted = true;
    uno_mag_plug(uno, 1);
    return 1;
}

void uno_mag_plug(uno_t *uno, uint8_t plugged)
{
    parts_t *parts = &uno->parts;

    parts->mag_plugged = parts->mag_fitted && plugged;
    if (parts->mag_plugged) { magnetometer_power_on(&parts->mag, uno->avr->cycle); }
    rearm_mag(uno);
}

void uno_mag_registers(const uno_t *uno, uint8_t *regs)
{
    memcpy(regs, uno->parts.mag.regs, MAGNETOMETER_REGISTERS);
}
