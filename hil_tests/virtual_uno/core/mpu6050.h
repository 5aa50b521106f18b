/* SPDX-License-Identifier: GPL-3.0-or-later */
/* mpu6050 - the IMU as its registers show it.
 *
 * Model     InvenSense RM-MPU-6000A-00 rev. 4.2 and PS-MPU-6000A-00 rev. 3.4. Asleep at reset
 *           (PWR_MGMT_1 = 0x40). Gyroscope output rate 8 kHz with DLPF_CFG 0 or 7, else 1 kHz,
 *           divided by 1 + SMPLRT_DIV; the accelerometer gives 1 kHz at most. A read of the sensor
 *           registers sees one sample: they are copied when the read begins. Rates are 0 until
 *           the gyroscope has started, 30 ms after waking. FIFO of 1024 bytes: when full, the
 *           oldest bytes go. INT: data ready and FIFO overflow, latched or for 50 us
 * Signals   the source gives what the sensors feel, delayed as DLPF_CFG says; or raw rows are
 *           played, one a sample, the last one held. Self-test adds what the trim codes promise
 * Not here  motion detection, low-power cycling, the auxiliary bus
 * Knows not the board: time is ticks of the caller's choice, outputs are callbacks
 */
#ifndef MPU6050_H
#define MPU6050_H

#include <stdbool.h>
#include <stdint.h>

#include "uno.h"

enum {
    MPU6050_REGISTERS = 128,
    MPU6050_FIFO      = 1024,
    MPU6050_SCHEDULED = 32,
    MPU6050_AXES      = 7 /* accelerometer, gyroscope, temperature */
};

typedef void (*mpu6050_source_fn)(void *ctx, const uint64_t *ticks, uint8_t dlpf, double *rows,
                                  uint32_t n);
typedef void (*mpu6050_int_fn)(void *ctx, uint8_t level);

typedef struct {
    double  hz;        /* ticks a second */
    double  clock_ppm; /* error of the part's own clock */
    uint8_t who_am_i;
    uint8_t trim[4]; /* SELF_TEST_X.. SELF_TEST_A, register map p. 9 */

    mpu6050_source_fn source;
    mpu6050_int_fn    int_moved;
    void             *ctx;

    uint8_t  regs[MPU6050_REGISTERS];
    uint8_t  shadow[2 * MPU6050_AXES]; /* ACCEL_XOUT_H.. as the read under way sees them */
    uint8_t  pointer;
    bool     pointer_set;
    bool     fresh;    /* the last sample was not read yet */
    uint64_t now;      /* as last told */
    uint64_t woken;    /* tick */
    double   grid;     /* exact instant of the next sample after the schedule */
    uint64_t int_ends; /* UINT64_MAX: no pulse under way */
    uint8_t  int_level;

    uint64_t ticks[MPU6050_SCHEDULED];
    double   rows[MPU6050_SCHEDULED][MPU6050_AXES];
    uint32_t next, count; /* count 0: nothing is scheduled, the part sleeps */
    bool     valued;      /* rows were asked for */

    const int16_t *played; /* rows of MPU6050_AXES; NULL: the source's */
    uint32_t       played_count, played_next;

    uint8_t  fifo[MPU6050_FIFO];
    uint16_t fifo_first, fifo_count;

    imu_stats_t stats;
} mpu6050_t;

void mpu6050_power_on(mpu6050_t *imu, uint64_t tick);
/* Lets time pass: samples that are due, the end of an INT pulse. */
void     mpu6050_advance(mpu6050_t *imu, uint64_t tick);
uint64_t mpu6050_next_tick(const mpu6050_t *imu);
/* Forgets values asked for ahead: the signal has changed. */
void mpu6050_restate(mpu6050_t *imu);

/* As a device on the bus; mpu6050_advance has been called for this tick. */
bool    mpu6050_start(mpu6050_t *imu, bool reading);
bool    mpu6050_write(mpu6050_t *imu, uint8_t byte);
uint8_t mpu6050_read(mpu6050_t *imu);

#endif
