/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "mpu6050.h"

#include <math.h>
#include <string.h>

enum {
    SELF_TEST_X  = 0x0D,
    SMPLRT_DIV   = 0x19,
    CONFIG       = 0x1A,
    GYRO_CONFIG  = 0x1B,
    ACCEL_CONFIG = 0x1C,
    FIFO_EN      = 0x23,
    INT_PIN_CFG  = 0x37,
    INT_ENABLE   = 0x38,
    INT_STATUS   = 0x3A,
    ACCEL_XOUT_H = 0x3B,
    GYRO_ZOUT_L  = 0x48,
    SIGNAL_PATH  = 0x68,
    USER_CTRL    = 0x6A,
    PWR_MGMT_1   = 0x6B,
    PWR_MGMT_2   = 0x6C,
    FIFO_COUNTH  = 0x72,
    FIFO_COUNTL  = 0x73,
    FIFO_R_W     = 0x74,
    WHO_AM_I     = 0x75,

    DATA_READY    = 0x01, /* INT_ENABLE, INT_STATUS */
    FIFO_OVERFLOW = 0x10,
    INT_LOW       = 0x80, /* INT_PIN_CFG: active low */
    INT_LATCHED   = 0x20,
    INT_ANY_READ  = 0x10, /* clears, not of INT_STATUS alone */
    DEVICE_RESET  = 0x80, /* PWR_MGMT_1 */
    SLEEP         = 0x40,
    TEMP_DISABLED = 0x08,
    FIFO_ON       = 0x40, /* USER_CTRL */
    FIFO_RESET    = 0x04,
    SIGNAL_RESET  = 0x01,

    GYRO_FIRST = 3, /* columns of a row */
    TEMP       = 6
};

static const double COUNTS_PER_DEG_S[4] = {131.0, 65.5, 32.8, 16.4};
#define COUNTS_PER_G_MOST 16384.0
#define GYRO_STARTS_S     0.030 /* PS p. 12 */
#define INT_PULSE_S       50e-6 /* RM p. 26 */

static bool asleep(const mpu6050_t *imu)
{
    return (imu->regs[PWR_MGMT_1] & SLEEP) != 0;
}

static double period_ticks(const mpu6050_t *imu)
{
    const uint8_t dlpf = imu->regs[CONFIG] & 7U;
    const double  rate = dlpf == 0U || dlpf == 7U ? 8000.0 : 1000.0;

    return imu->hz * (1.0 + imu->regs[SMPLRT_DIV]) / (rate * (1.0 + imu->clock_ppm * 1e-6));
}

static void plan(mpu6050_t *imu)
{
    for (imu->count = 0; imu->count < MPU6050_SCHEDULED; imu->count++) {
        imu->ticks[imu->count] = (uint64_t)imu->grid;
        imu->grid += period_ticks(imu);
    }
    imu->next   = 0;
    imu->valued = false;
}

static void reschedule(mpu6050_t *imu)
{
    imu->count = 0;
    if (asleep(imu)) { return; }
    imu->grid = (double)imu->now + period_ticks(imu);
    plan(imu);
}

void mpu6050_restate(mpu6050_t *imu)
{
    imu->valued = false;
}

/* --- interrupt pin --- */

static void drive_int(mpu6050_t *imu, bool active)
{
    const uint8_t level = active == !(imu->regs[INT_PIN_CFG] & INT_LOW);

    imu->int_ends  = UINT64_MAX;
    imu->int_level = level;
    if (imu->int_moved) { imu->int_moved(imu->ctx, level); }
}

static void raise(mpu6050_t *imu, uint8_t what)
{
    imu->regs[INT_STATUS] |= what;
    if (!(imu->regs[INT_ENABLE] & what)) { return; }
    drive_int(imu, true);
    if (!(imu->regs[INT_PIN_CFG] & INT_LATCHED)) {
        imu->int_ends = imu->now + (uint64_t)(INT_PULSE_S * imu->hz);
    }
}

static void clear_status(mpu6050_t *imu)
{
    imu->regs[INT_STATUS] = 0;
    if (imu->regs[INT_PIN_CFG] & INT_LATCHED) { drive_int(imu, false); }
}

/* --- reset --- */

static void reset_fifo(mpu6050_t *imu)
{
    imu->fifo_count = imu->fifo_first = 0;
}

static void clear_sensors(mpu6050_t *imu)
{
    memset(imu->regs + ACCEL_XOUT_H, 0, 2 * MPU6050_AXES);
}

static void reset(mpu6050_t *imu)
{
    memset(imu->regs, 0, sizeof imu->regs);
    memcpy(imu->regs + SELF_TEST_X, imu->trim, sizeof imu->trim);
    imu->regs[PWR_MGMT_1] = SLEEP;
    imu->regs[WHO_AM_I]   = imu->who_am_i;
    reset_fifo(imu);
    drive_int(imu, false);
    reschedule(imu);
    imu->stats.resets++;
}

void mpu6050_power_on(mpu6050_t *imu, uint64_t tick)
{
    imu->now         = tick;
    imu->pointer_set = false;
    imu->pointer     = 0;
    reset(imu);
}

/* --- samples --- */

/* Trim codes of an axis, and what its self-test adds: RM pp. 9-12. */
static double self_test_counts(const mpu6050_t *imu, uint8_t column)
{
    const uint8_t *trim = imu->trim;

    if (column >= GYRO_FIRST) {
        const uint8_t code = trim[column - GYRO_FIRST] & 0x1FU;
        const double  sign = column == GYRO_FIRST + 1 ? -25.0 : 25.0;
        return code ? sign * 131.0 * pow(1.046, code - 1.0) : 0.0;
    }
    const uint8_t code = (uint8_t)((trim[column] >> 3 & 0x1CU) |
                                   (trim[3] >> (4 - 2 * column) & 3U));
    return code ? 4096.0 * 0.34 * pow(0.92 / 0.34, (code - 1.0) / 30.0) : 0.0;
}

static double counts_of(const mpu6050_t *imu, uint8_t column, double felt)
{
    if (column == TEMP) { return (felt - 36.53) * 340.0; } /* RM p. 30 */
    const bool    gyro  = column >= GYRO_FIRST;
    const uint8_t how   = imu->regs[gyro ? GYRO_CONFIG : ACCEL_CONFIG];
    const uint8_t range = how >> 3 & 3U;
    const double  scale = gyro ? COUNTS_PER_DEG_S[range] : COUNTS_PER_G_MOST / (1U << range);
    const uint8_t axis  = column % 3U;

    if (gyro && (double)(imu->now - imu->woken) < GYRO_STARTS_S * imu->hz) { return 0.0; }
    if (how & 0x80U >> axis) {
        felt += self_test_counts(imu, column) / (gyro ? COUNTS_PER_DEG_S[0] : 4096.0);
    }
    return felt * scale;
}

static int16_t limited(double counts)
{
    if (!(counts < 32767.0)) { return 32767; }
    return counts < -32768.0 ? -32768 : (int16_t)lrint(counts);
}

/* Register of a column: the temperature stands between the two sensors. */
static uint8_t register_of(uint8_t column)
{
    const uint8_t place = column == TEMP ? 3U : column < GYRO_FIRST ? column : column + 1U;

    return (uint8_t)(ACCEL_XOUT_H + 2U * place);
}

static bool measures(const mpu6050_t *imu, uint8_t column)
{
    if (column == TEMP) { return !(imu->regs[PWR_MGMT_1] & TEMP_DISABLED); }
    return !(imu->regs[PWR_MGMT_2] & 0x20U >> column); /* STBY_XA.. STBY_ZG */
}

static void push(mpu6050_t *imu, uint8_t byte)
{
    if (imu->fifo_count == MPU6050_FIFO) {
        imu->fifo_first = (uint16_t)((imu->fifo_first + 1U) % MPU6050_FIFO);
        imu->fifo_count--;
        imu->stats.fifo_lost++;
        raise(imu, FIFO_OVERFLOW);
    }
    imu->fifo[(imu->fifo_first + imu->fifo_count) % MPU6050_FIFO] = byte;
    imu->fifo_count++;
}

static uint8_t pop(mpu6050_t *imu)
{
    const uint8_t byte = imu->fifo[imu->fifo_first];

    if (imu->fifo_count) {
        imu->fifo_first = (uint16_t)((imu->fifo_first + 1U) % MPU6050_FIFO);
        imu->fifo_count--;
    }
    return byte;
}

/* In the order of their registers; FIFO_EN has one bit for all of the accelerometer. */
static void fill_fifo(mpu6050_t *imu)
{
    static const uint8_t enabled_by[MPU6050_AXES] = {0x08, 0x08, 0x08, 0x80, 0x40, 0x20, 0x10};

    for (uint8_t place = 0; place < MPU6050_AXES; place++) {
        if (!(imu->regs[FIFO_EN] & enabled_by[place])) { continue; }
        push(imu, imu->regs[ACCEL_XOUT_H + 2 * place]);
        push(imu, imu->regs[ACCEL_XOUT_H + 2 * place + 1]);
    }
}

static void sample(mpu6050_t *imu)
{
    if (!imu->valued && !imu->played && imu->source) {
        imu->source(imu->ctx, imu->ticks + imu->next, imu->regs[CONFIG] & 7U, imu->rows[imu->next],
                    imu->count - imu->next);
        imu->valued = true;
    }
    for (uint8_t column = 0; column < MPU6050_AXES; column++) {
        if (!measures(imu, column)) { continue; }
        int16_t counts;
        if (imu->played) {
            counts = imu->played[MPU6050_AXES * imu->played_next + column];
        } else {
            counts = limited(counts_of(imu, column, imu->rows[imu->next][column]));
        }
        const uint8_t at   = register_of(column);
        imu->regs[at]      = (uint8_t)((uint16_t)counts >> 8);
        imu->regs[at + 1U] = (uint8_t)counts;
    }
    if (imu->played && imu->played_next + 1U < imu->played_count) { imu->played_next++; }
    imu->stats.samples++;
    if (imu->fresh) { imu->stats.samples_unread++; }
    imu->fresh = true;
    if (imu->regs[USER_CTRL] & FIFO_ON) { fill_fifo(imu); }
    raise(imu, DATA_READY);
}

uint64_t mpu6050_next_tick(const mpu6050_t *imu)
{
    const uint64_t due = imu->count ? imu->ticks[imu->next] : UINT64_MAX;

    return due < imu->int_ends ? due : imu->int_ends;
}

void mpu6050_advance(mpu6050_t *imu, uint64_t tick)
{
    for (uint64_t due; (due = mpu6050_next_tick(imu)) <= tick;) {
        imu->now = due;
        if (due == imu->int_ends) {
            drive_int(imu, false);
            continue;
        }
        sample(imu);
        if (++imu->next == imu->count) { plan(imu); }
    }
    imu->now = tick;
}

/* --- on the bus --- */

static bool is_read_only(uint8_t reg)
{
    return reg < SELF_TEST_X || (reg >= 0x35U && reg < INT_PIN_CFG) ||
           (reg >= INT_STATUS && reg <= 0x60U) || reg == FIFO_COUNTH || reg == FIFO_COUNTL ||
           reg >= WHO_AM_I;
}

static void write_register(mpu6050_t *imu, uint8_t reg, uint8_t v)
{
    const bool slept = asleep(imu);

    if (reg == FIFO_R_W) { push(imu, v); }
    if (is_read_only(reg) || reg == FIFO_R_W) { return; }
    if (reg == PWR_MGMT_1 && v & DEVICE_RESET) {
        reset(imu);
        return;
    }
    imu->regs[reg] = v;
    if (reg == USER_CTRL) {
        if (v & FIFO_RESET) { reset_fifo(imu); }
        if (v & SIGNAL_RESET) { clear_sensors(imu); }
        imu->regs[reg] = v & 0xF8U;
    } else if (reg == SIGNAL_PATH) {
        if (v & 7U) { clear_sensors(imu); }
        imu->regs[reg] = 0;
    } else if (reg == INT_PIN_CFG) {
        drive_int(imu, false);
    } else if (reg == SMPLRT_DIV || reg == CONFIG || slept != asleep(imu)) {
        if (slept && !asleep(imu)) { imu->woken = imu->now; }
        reschedule(imu);
    }
}

bool mpu6050_start(mpu6050_t *imu, bool reading)
{
    if (reading) {
        memcpy(imu->shadow, imu->regs + ACCEL_XOUT_H, sizeof imu->shadow);
        const uint8_t reg = imu->pointer;
        if (reg >= ACCEL_XOUT_H && reg <= GYRO_ZOUT_L) { imu->fresh = false; }
        if (imu->regs[INT_PIN_CFG] & INT_ANY_READ && reg != INT_STATUS) { clear_status(imu); }
    } else {
        imu->pointer_set = false;
    }
    return true;
}

bool mpu6050_write(mpu6050_t *imu, uint8_t byte)
{
    if (imu->pointer_set) {
        write_register(imu, imu->pointer, byte);
        if (imu->pointer != FIFO_R_W) { imu->pointer = (imu->pointer + 1U) & 0x7FU; }
    } else {
        imu->pointer     = byte & 0x7FU;
        imu->pointer_set = true;
    }
    return true;
}

uint8_t mpu6050_read(mpu6050_t *imu)
{
    const uint8_t reg = imu->pointer;
    uint8_t       v   = imu->regs[reg];

    if (reg == FIFO_R_W) { return pop(imu); } /* its address stays */
    imu->pointer = (reg + 1U) & 0x7FU;
    if (reg >= ACCEL_XOUT_H && reg <= GYRO_ZOUT_L) { v = imu->shadow[reg - ACCEL_XOUT_H]; }
    if (reg == INT_STATUS) { clear_status(imu); }
    if (reg == FIFO_COUNTH) { v = (uint8_t)(imu->fifo_count >> 8); }
    if (reg == FIFO_COUNTL) { v = (uint8_t)imu->fifo_count; }
    return v;
}
