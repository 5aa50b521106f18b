/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "magnetometer.h"

#include <math.h>
#include <string.h>

enum {
    AXES = 3,

    QMC_STATUS   = 0x06,
    QMC_CONTROL1 = 0x09,
    QMC_CONTROL2 = 0x0A,
    QMC_PERIOD   = 0x0B,
    QMC_ID       = 0x0D,
    QMC_DRDY     = 0x01,
    QMC_OVL      = 0x02,
    QMC_DOR      = 0x04,
    QMC_RESET    = 0x80,

    HMC_CONFIG_A = 0x00,
    HMC_CONFIG_B = 0x01,
    HMC_MODE     = 0x02,
    HMC_DATA     = 0x03,
    HMC_LAST     = 0x08,
    HMC_STATUS   = 0x09,
    HMC_ID       = 0x0A,
    HMC_RDY      = 0x01,
    HMC_BEYOND   = -4096
};

static const double  QMC_RATES[4]    = {10.0, 50.0, 100.0, 200.0};
static const double  HMC_RATES[8]    = {0.75, 1.5, 3.0, 7.5, 15.0, 30.0, 75.0, 75.0};
static const double  HMC_GAINS[8]    = {1370, 1090, 820, 660, 440, 390, 330, 230};
static const uint8_t HMC_PLACE[AXES] = {0, 2, 1}; /* X Z Y */
#define HMC_SINGLE_S 0.006
#define NEVER        ((double)INFINITY)

static bool is_qmc(const magnetometer_t *mag)
{
    return mag->kind == UNO_MAG_QMC5883L;
}

static double period_ticks(const magnetometer_t *mag)
{
    if (is_qmc(mag)) {
        const uint8_t control = mag->regs[QMC_CONTROL1];
        return (control & 3U) == 1U ? mag->hz / QMC_RATES[control >> 2 & 3U] : NEVER;
    }
    if ((mag->regs[HMC_MODE] & 3U) == 1U) { return mag->single ? mag->hz * HMC_SINGLE_S : NEVER; }
    if ((mag->regs[HMC_MODE] & 3U) != 0U) { return NEVER; }
    return mag->hz / HMC_RATES[mag->regs[HMC_CONFIG_A] >> 2 & 7U];
}

static void reschedule(magnetometer_t *mag)
{
    mag->due = (double)mag->now + period_ticks(mag);
}

void magnetometer_power_on(magnetometer_t *mag, uint64_t tick)
{
    memset(mag->regs, 0, sizeof mag->regs);
    mag->now         = tick;
    mag->pointer_set = false;
    mag->pointer     = 0;
    mag->single      = false;
    if (is_qmc(mag)) {
        mag->regs[QMC_ID] = 0xFF;
    } else {
        mag->regs[HMC_CONFIG_A] = 0x10;
        mag->regs[HMC_CONFIG_B] = 0x20;
        mag->regs[HMC_MODE]     = 0x01;
        memcpy(mag->regs + HMC_ID, "H43", 3);
    }
    reschedule(mag);
}

static void put_qmc(magnetometer_t *mag, const double field[AXES])
{
    const double scale  = mag->regs[QMC_CONTROL1] & 0x10U ? 3000.0 : 12000.0;
    uint8_t      status = QMC_DRDY;

    if (mag->regs[QMC_STATUS] & QMC_DRDY) { status |= QMC_DOR; }
    for (uint8_t axis = 0; axis < AXES; axis++) {
        double counts = field[axis] * scale;
        if (fabs(counts) > 32767.0) {
            status |= QMC_OVL;
            counts = counts > 0.0 ? 32767.0 : -32768.0;
        }
        const uint16_t bits      = (uint16_t)lrint(counts);
        mag->regs[2 * axis]      = (uint8_t)bits;
        mag->regs[2 * axis + 1U] = (uint8_t)(bits >> 8);
    }
    mag->regs[QMC_STATUS] = status;
}

static void put_hmc(magnetometer_t *mag, const double field[AXES])
{
    const double gain = HMC_GAINS[mag->regs[HMC_CONFIG_B] >> 5];

    for (uint8_t axis = 0; axis < AXES; axis++) {
        const double   counts = field[axis] * gain;
        const uint16_t bits   = (uint16_t)(fabs(counts) > 2047.0 ? HMC_BEYOND : lrint(counts));
        const uint8_t  at     = (uint8_t)(HMC_DATA + 2U * HMC_PLACE[axis]);
        mag->regs[at]         = (uint8_t)(bits >> 8);
        mag->regs[at + 1U]    = (uint8_t)bits;
    }
    mag->regs[HMC_STATUS] = HMC_RDY;
}

uint64_t magnetometer_next_tick(const magnetometer_t *mag)
{
    return isinf(mag->due) ? UINT64_MAX : (uint64_t)mag->due;
}

void magnetometer_advance(magnetometer_t *mag, uint64_t tick)
{
    for (uint64_t due; (due = magnetometer_next_tick(mag)) <= tick;) {
        double field[AXES] = {0.0, 0.0, 0.0};
        mag->now           = due;
        mag->source(mag->ctx, due, field);
        if (is_qmc(mag)) {
            put_qmc(mag, field);
        } else {
            put_hmc(mag, field);
        }
        mag->samples++;
        mag->single = false;
        mag->due += period_ticks(mag);
    }
    mag->now = tick;
}

bool magnetometer_start(magnetometer_t *mag, bool reading)
{
    if (!reading) { mag->pointer_set = false; }
    return true;
}

static void write_register(magnetometer_t *mag, uint8_t reg, uint8_t v)
{
    if (is_qmc(mag)) {
        if (reg == QMC_CONTROL2 && v & QMC_RESET) {
            magnetometer_power_on(mag, mag->now);
        } else if (reg >= QMC_CONTROL1 && reg <= QMC_PERIOD) {
            mag->regs[reg] = v;
            if (reg == QMC_CONTROL1) { reschedule(mag); }
        }
    } else if (reg <= HMC_MODE) {
        mag->regs[reg] = v;
        mag->single    = reg == HMC_MODE && (v & 3U) == 1U;
        if (reg != HMC_CONFIG_B) { reschedule(mag); }
    }
}

bool magnetometer_write(magnetometer_t *mag, uint8_t byte)
{
    if (mag->pointer_set) {
        write_register(mag, mag->pointer, byte);
        mag->pointer = (mag->pointer + 1U) % MAGNETOMETER_REGISTERS;
    } else {
        mag->pointer     = byte % MAGNETOMETER_REGISTERS;
        mag->pointer_set = true;
    }
    return true;
}

uint8_t magnetometer_read(magnetometer_t *mag)
{
    const uint8_t reg = mag->pointer;
    const uint8_t v   = mag->regs[reg];

    mag->pointer = (reg + 1U) % MAGNETOMETER_REGISTERS;
    if (is_qmc(mag)) {
        if (reg < QMC_STATUS) { mag->regs[QMC_STATUS] &= (uint8_t) ~(QMC_DRDY | QMC_DOR); }
    } else if (reg == HMC_LAST) {
        mag->pointer          = HMC_DATA;
        mag->regs[HMC_STATUS] = 0;
    }
    return v;
}
