/* SPDX-License-Identifier: MIT */
#include "mpu6050_motion.h"

#include "idle.h"
#include "mpu6050_internal.h"
#include "mpu6050_registers.h"
#include "port_clamp.h"
#include "port_outline.h"
#include "port_reach.h"
#include "rom_next.h"
#include "twi.h"
#include "uno_pins.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <stddef.h>

/* Transfers in the order in which they follow each other, and from SETTLE on waits. A transfer's
 * number is where its row of `transfers` stands, and a row. */
enum {
    ROW       = 4,
    OFF       = 0,
    IDENTIFY  = 1 * ROW,
    WAKE      = 2 * ROW,
    SET_INT   = 3 * ROW,
    SET_RATES = 4 * ROW,
    GUARD     = 5 * ROW,
    BURST     = 6 * ROW,
    SETTLE    = 7 * ROW,
    ABSENT    = 8 * ROW
};

/* In units of 1.024 ms; a wait is looked at every 33 ms at least, and must not reach 256. */
enum { SETTLE_TIME = 35, RETRY_TIME = 200 };

/* In ticks of 0.5 us. */
enum {
    PERIOD     = 2000,
    LEND_TIME  = 1400, /* after data were ready, at 1 kHz: 0.3 ms are left */
    EARLY_MOST = 4000  /* of data after the time that the caller gives */
};

enum { GUARD_EVERY = 8 };

/* Where they stand in what is written. */
enum { RATES = 0, GUARDED = 3, INT_PIN = 4, INT_LEN = 2, PWR = 5 };

enum {
    DLPF_188_HZ = 1,
    DLPF_98_HZ  = 2,
    RANGE_MOST  = 0x18, /* +-2000 deg/s, +-16 g */
    RANGE_8_G   = 0x10,
    EXCITED     = 0xE0
};

/* SMPLRT_DIV, CONFIG, GYRO_CONFIG, ACCEL_CONFIG; the last is the guard, which a reset changes. */
static const uint8_t modes[][MPU6050_RATES_LEN] PROGMEM = {
    {1, DLPF_98_HZ, RANGE_MOST, RANGE_MOST}, {0, DLPF_188_HZ, RANGE_MOST, RANGE_MOST},
    {0, DLPF_188_HZ, 0, RANGE_8_G},          {0, DLPF_188_HZ, EXCITED, EXCITED | RANGE_8_G},
    {0, DLPF_188_HZ, 0, RANGE_8_G},
};

mpu6050_t mpu6050;

_Static_assert(MPU6050_CLOCK_GYRO_X == 1, "one byte serves PWR_MGMT_1 and INT_ENABLE");

typedef struct {
    uint8_t sla, reg, at, len;
} transfer_t;

#define TO(register_, field, length)                                            \
    {                                                                           \
        MPU6050_ADDRESS << 1, (register_), offsetof(mpu6050_t, field), (length) \
    }
#define FROM(register_, field, length)                                              \
    {                                                                               \
        MPU6050_ADDRESS << 1 | 1, (register_), offsetof(mpu6050_t, field), (length) \
    }

_Static_assert(sizeof(transfer_t) == ROW, "steps are numbered so");

static const transfer_t transfers[] PROGMEM = {
    FROM(MPU6050_WHO_AM_I_REG, identity, 1),
    TO(MPU6050_PWR_MGMT_1, settings[PWR], 1),
    TO(MPU6050_INT_PIN_CFG, settings[INT_PIN], INT_LEN),
    TO(MPU6050_SMPLRT_DIV, settings[RATES], MPU6050_RATES_LEN),
    FROM(MPU6050_ACCEL_CONFIG, guard, 1),
    FROM(MPU6050_ACCEL_XOUT_H, burst, MPU6050_BURST_LEN),
};

/* --- pacing --- */

static void pace(bool on)
{
    TIFR1  = _BV(OCF1A); /* a time long gone */
    PCICR  = on ? _BV(PCIE2) : 0U;
    TIMSK1 = on ? _BV(TOIE1) | _BV(OCIE1A) : _BV(TOIE1);
}

static void stop(void)
{
    pace(false);
    IDLE_FLAGS &= (uint8_t)~_BV(IMU_WAITS_BIT);
    IDLE_FLAGS &= (uint8_t)~_BV(IMU_ARMED_BIT);
}

/* --- steps --- */

static void wait_in(mpu6050_t *it, uint8_t step, uint8_t now)
{
    it->step  = step;
    it->since = now;
}

static PORT_OUTLINE void lay_ready(mpu6050_t *it, uint8_t step)
{
    const uint8_t *row = (const uint8_t *)transfers + (uint8_t)(step - IDENTIFY);
    const uint8_t  sla = rom_next(&row);
    uint8_t        reg = rom_next(&row);
    const uint8_t  at  = rom_next(&row);
    const uint8_t  len = rom_next(&row);

    it->step = step;
    if (step == BURST && it->mode == MPU6050_TRIM) { reg = MPU6050_SELF_TEST_X; }
    twi_ready(sla, reg, (uint8_t *)it + at, len);
}

static void arm(mpu6050_t *it)
{
    lay_ready(it, BURST);
    cli();
    if ((IDLE_FLAGS & _BV(IMU_WAITS_BIT)) != 0U) {
        IDLE_FLAGS &= (uint8_t)~_BV(IMU_WAITS_BIT);
        it->due = it->waiting_due;
        twi_go();
    } else {
        IDLE_FLAGS |= _BV(IMU_ARMED_BIT);
    }
    sei();
}

void mpu6050_motion_start(uint8_t mode)
{
    mpu6050.mode     = mode;
    mpu6050.is_asked = true;
}

/* false: not to be asked. */
static bool begin(mpu6050_t *it)
{
    it->is_asked = false;
    it->step     = OFF;
    if (it->mode == MPU6050_OFF) { return false; }
    const uint8_t *from = modes[it->mode - 1U];
    uint8_t       *to   = it->settings;
    for (uint8_t left = MPU6050_RATES_LEN; left != 0U; left--) { *to++ = rom_next(&from); }
    it->settings[PWR] = 1; /* INT_PIN_CFG stays 0: active high, 50 us */
    it->period        = it->mode == MPU6050_500HZ ? 2U * PERIOD + MPU6050_PATIENCE
                                                  : PERIOD + MPU6050_PATIENCE;
    twi_init();
    IMU_PORT |= _BV(IMU_INT); /* an open line is quiet */
    PCMSK2 = _BV(IMU_PCINT);
    return true;
}

/* Bytes into words; false: all are 0. */
static bool read_burst(const mpu6050_t *it, mpu6050_sample_t *sample)
{
    const uint8_t *from = it->burst;
    uint8_t       *to   = (uint8_t *)sample;
    uint8_t        any  = 0;
    uint8_t        left = MPU6050_WORDS;
    uint8_t        high, low;

    __asm__ volatile("1:\n\t"
                     "ld %[high], Z+\n\t"
                     "ld %[low], Z+\n\t"
                     "st X+, %[low]\n\t"
                     "st X+, %[high]\n\t"
                     "or %[any], %[high]\n\t"
                     "or %[any], %[low]\n\t"
                     "dec %[left]\n\t"
                     "brne 1b"
                     : "+z"(from), "+x"(to), [any] "+r"(any), [left] "+r"(left), [high] "=&r"(high),
                       [low] "=&r"(low)::"memory");
    return any != 0U;
}

static void stamp(const mpu6050_t *it, mpu6050_sample_t *sample, uint32_t now_us)
{
    const uint16_t age = (uint16_t)((uint16_t)((uint16_t)now_us << 1) + EARLY_MOST - it->due);

    sample->device_us = now_us + EARLY_MOST / 2 - (age >> 1);
}

/* What was under way has ended; the step that follows, BURST where a sample has come, OFF for
 * none yet. */
static uint8_t after(mpu6050_t *it, uint8_t status, mpu6050_sample_t *sample, uint8_t now)
{
    const uint8_t step = it->step;

    if (step >= SETTLE) {
        const uint8_t waited = (uint8_t)(now - it->since);
        if (step == ABSENT) {
            if (waited < RETRY_TIME) { return OFF; }
            return IDENTIFY;
        }
        if (waited < SETTLE_TIME) { return OFF; }
        it->guard_left = 1;
        arm(it);
        pace(true);
        return OFF;
    }
    if (status == TWI_IDLE) {
        if (step < SET_RATES) { return (uint8_t)(step + ROW); }
        if (step == SET_RATES) {
            wait_in(it, SETTLE, now);
            return OFF;
        }
        if (step == BURST) {
            it->guard_left--;
            if (it->guard_left == 0U) { return GUARD; }
            it->guard = it->settings[GUARDED];
        } else {
            it->guard_left = GUARD_EVERY;
        }
        if (read_burst(it, sample) && it->guard == it->settings[GUARDED]) { return BURST; }
    }
    stop();
    if (step == IDENTIFY) {
        wait_in(it, ABSENT, now);
        return OFF;
    }
    if (step >= GUARD) { port_count(&it->counters.losses); }
    return IDENTIFY;
}

bool mpu6050_motion_poll(mpu6050_sample_t *sample, uint32_t now_us)
{
    mpu6050_t *const it   = PORT_REACH(&mpu6050);
    const uint8_t    now  = twi_time(now_us);
    uint8_t          next = OFF;

    if (mpu6050_is_lent()) { return false; }
    if (it->is_asked) { stop(); }
    if ((IDLE_FLAGS & _BV(IMU_ARMED_BIT)) != 0U) { return false; }
    const uint8_t status = twi_poll(now);
    if (status == TWI_BUSY) { return false; }
    if (it->is_asked) {
        if (begin(it)) { next = IDENTIFY; }
    } else if (it->step != OFF) {
        next = after(it, status, sample, now);
    }
    if (next == OFF) { return false; }
    if (next == BURST) {
        stamp(it, sample, now_us);
        arm(it);
        return true;
    }
    lay_ready(it, next);
    twi_go();
    return false;
}

bool mpu6050_is_lent(void)
{
    return (IDLE_FLAGS & _BV(IMU_LENT_BIT)) != 0U;
}

bool mpu6050_lend(void)
{
    mpu6050_t *const it   = PORT_REACH(&mpu6050);
    bool             lent = it->step >= SETTLE;

    cli();
    if ((IDLE_FLAGS & _BV(IMU_ARMED_BIT)) != 0U && (uint16_t)(TCNT1 - it->due) <= LEND_TIME) {
        IDLE_FLAGS &= (uint8_t)~_BV(IMU_ARMED_BIT);
        lent = true;
    }
    sei();
    if (lent) { IDLE_FLAGS |= _BV(IMU_LENT_BIT); }
    return lent;
}

void mpu6050_give_back(void)
{
    IDLE_FLAGS &= (uint8_t)~_BV(IMU_LENT_BIT);
    if (mpu6050.step == BURST) { arm(&mpu6050); }
}

mpu6050_state_t mpu6050_state(void)
{
    const uint8_t step = mpu6050.step;

    if (step >= SETTLE) { return step == SETTLE ? MPU6050_STARTING : MPU6050_ABSENT; }
    if (step >= GUARD) { return MPU6050_RUNNING; }
    return step > IDENTIFY ? MPU6050_STARTING : MPU6050_ABSENT;
}

uint8_t mpu6050_identity(void)
{
    return mpu6050.identity;
}

mpu6050_counters_t mpu6050_counters(void)
{
    cli();
    const mpu6050_counters_t now = mpu6050.counters;
    sei();
    return now;
}
