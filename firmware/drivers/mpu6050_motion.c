/* SPDX-License-Identifier: MIT */
#include "mpu6050_motion.h"

#include "idle.h"
#include "mpu6050_registers.h"
#include "port_clamp.h"
#include "port_reach.h"
#include "twi.h"
#include "uno_pins.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <stddef.h>

enum { WORDS = 7, BURST_LEN = 2 * WORDS };

/* Transfers in the order in which they follow each other, and from SETTLE on waits. */
enum { IDENTIFY, WAKE, SET_INT, SET_RATES, GUARD, BURST, SETTLE, ABSENT, OFF };

/* In units of 1.024 ms; a wait is looked at every 33 ms at least, and must not reach 256. */
enum { SETTLE_TIME = 35, RETRY_TIME = 200 };

/* In ticks of 0.5 us. */
enum {
    PATIENCE   = 256, /* more than 3 % of a period, by which the part's clock may be slow */
    PERIOD     = 2000,
    LEND_TIME  = 1400, /* after data were ready, at 1 kHz: 0.3 ms are left */
    EARLY_MOST = 4000  /* of data after the time that the caller gives */
};

enum { GUARD_EVERY = 8 };

/* What is written, in the order of the registers. */
enum { RATES = 0, RATES_LEN = 4, GUARDED = 3, INT_PIN = 4, INT_LEN = 2, PWR = 5 };

enum {
    DLPF_188_HZ = 1,
    DLPF_98_HZ  = 2,
    RANGE_MOST  = 0x18, /* +-2000 deg/s, +-16 g */
    RANGE_8_G   = 0x10,
    EXCITED     = 0xE0
};

/* SMPLRT_DIV, CONFIG, GYRO_CONFIG, ACCEL_CONFIG; the last is the guard, which a reset changes. */
static const uint8_t modes[][RATES_LEN] PROGMEM = {
    {1, DLPF_98_HZ, RANGE_MOST, RANGE_MOST}, {0, DLPF_188_HZ, RANGE_MOST, RANGE_MOST},
    {0, DLPF_188_HZ, 0, RANGE_8_G},          {0, DLPF_188_HZ, EXCITED, EXCITED | RANGE_8_G},
    {0, DLPF_188_HZ, 0, RANGE_8_G},
};

typedef struct {
    uint8_t           step;
    bool              is_asked; /* to begin anew */
    bool              is_lent;
    uint8_t           mode;
    uint8_t           since;      /* when a wait began, 1.024 ms */
    uint8_t           guard_left; /* bursts until the guard is read */
    uint8_t           guard;      /* as read */
    uint8_t           identity;
    uint8_t           settings[RATES_LEN + INT_LEN];
    uint8_t           burst[BURST_LEN];
    uint16_t          period; /* main loop writes, interrupts read; tick */
    volatile uint16_t due;    /* tick of the burst under way; who begins it writes, poll reads */
    volatile uint16_t
        waiting_due; /* interrupts write while none waits; poll reads while one does */
    mpu6050_counters_t counters;
} imu_t;

/* INT_PIN_CFG: active high, 50 us. INT_ENABLE: data ready. The 1 also wakes the part. */
static imu_t imu = {.step = OFF, .settings = {[INT_PIN] = 0, [PWR] = 1}};

_Static_assert(MPU6050_CLOCK_GYRO_X == 1, "one byte serves PWR_MGMT_1 and INT_ENABLE");

typedef struct {
    uint8_t sla, reg, at, len;
} transfer_t;

#define TO(register_, field, length)                                        \
    {                                                                       \
        MPU6050_ADDRESS << 1, (register_), offsetof(imu_t, field), (length) \
    }
#define FROM(register_, field, length)                                          \
    {                                                                           \
        MPU6050_ADDRESS << 1 | 1, (register_), offsetof(imu_t, field), (length) \
    }

static const transfer_t transfers[] PROGMEM = {
    FROM(MPU6050_WHO_AM_I_REG, identity, 1),
    TO(MPU6050_PWR_MGMT_1, settings[PWR], 1),
    TO(MPU6050_INT_PIN_CFG, settings[INT_PIN], INT_LEN),
    TO(MPU6050_SMPLRT_DIV, settings[RATES], RATES_LEN),
    FROM(MPU6050_ACCEL_CONFIG, guard, 1),
    FROM(MPU6050_ACCEL_XOUT_H, burst, BURST_LEN),
};

/* --- pacing --- */

static inline __attribute__((always_inline)) void enter(void)
{
    __asm__ volatile("push r24\n\t"
                     "in r24, __SREG__\n\t"
                     "push r24\n\t"
                     "push r25\n\t"
                     "push r30\n\t"
                     "push r31\n\t"
                     "%~call idle_note_waking" ::
                         : "memory");
}

/* INT has moved. From mpu6050_is_due on r24, r25 hold the tick when data were ready: the burst that
 * lies ready is begun, or it is noted that one waits. Work is posted for it, so that the main loop
 * sees a burst that takes too long. */
ISR(IMU_INT_vect, ISR_NAKED)
{
    enter();
    __asm__ volatile(
        "sbis %[pin], %[line]\n\t"
        "rjmp 4f\n\t" /* its end */
        "lds r24, %[count]\n\t"
        "lds r25, %[count] + 1\n"
        ".global mpu6050_is_due\n"
        "mpu6050_is_due:\n\t"
        "sbis %[flags], %[armed]\n\t"
        "rjmp 1f\n\t"
        "cbi %[flags], %[armed]\n\t"
        "sts %[due], r24\n\t"
        "sts %[due] + 1, r25\n\t"
        "ldi r30, %[start]\n\t"
        "sts %[twcr], r30\n\t"
        "rjmp 3f\n"
        "1:\n\t"
        "sbi %[flags], %[work]\n\t"
        "sbic %[flags], %[waits]\n\t"
        "rjmp 2f\n\t"
        "sbi %[flags], %[waits]\n\t"
        "sts %[waiting], r24\n\t"
        "sts %[waiting] + 1, r25\n\t"
        "rjmp 3f\n"
        "2:\n\t"
        "lds r30, %[overruns]\n\t"
        "lds r31, %[overruns] + 1\n\t"
        "adiw r30, 1\n\t"
        "breq 3f\n\t"
        "sts %[overruns] + 1, r31\n\t"
        "sts %[overruns], r30\n"
        "3:\n\t"
        "lds r30, %[period]\n\t"
        "lds r31, %[period] + 1\n\t"
        "add r24, r30\n\t"
        "adc r25, r31\n\t"
        "sts %[compare] + 1, r25\n\t" /* high byte first: the low one takes both over */
        "sts %[compare], r24\n"
        "4:\n\t"
        "pop r31\n\t"
        "pop r30\n\t"
        "pop r25\n\t"
        "pop r24\n\t"
        "out __SREG__, r24\n\t"
        "pop r24\n\t"
        "reti" ::[pin] "I"(_SFR_IO_ADDR(IMU_PIN)),
        [line] "I"(IMU_INT), [count] "n"(_SFR_MEM_ADDR(TCNT1)),
        [flags] "I"(_SFR_IO_ADDR(IDLE_FLAGS)), [armed] "I"(IMU_ARMED_BIT),
        [waits] "I"(IMU_WAITS_BIT), [work] "I"(IDLE_WORK_BIT), [due] "i"(&imu.due),
        [waiting] "i"(&imu.waiting_due), [period] "i"(&imu.period),
        [overruns] "i"(&imu.counters.overruns), [twcr] "n"(_SFR_MEM_ADDR(TWCR)),
        [start] "n"(_BV(TWINT) | _BV(TWEN) | _BV(TWIE) | _BV(TWSTA)),
        [compare] "n"(_SFR_MEM_ADDR(OCR1A))
        : "memory");
}

/* No edge has come for a period: data were ready then. */
ISR(TIMER1_COMPA_vect, ISR_NAKED)
{
    enter();
    __asm__ volatile("lds r24, %[compare]\n\t"
                     "lds r25, %[compare] + 1\n\t"
                     "subi r25, %[patience]\n\t"
                     "%~jmp mpu6050_is_due" ::[compare] "n"(_SFR_MEM_ADDR(OCR1A)),
                     [patience] "M"(PATIENCE >> 8)
                     : "memory");
}

static void pace(bool on)
{
    TIFR1  = _BV(OCF1A); /* a time long gone */
    PCICR  = on ? _BV(PCIE2) : 0U;
    TIMSK1 = on ? _BV(TOIE1) | _BV(OCIE1A) : _BV(TOIE1);
    IDLE_FLAGS &= (uint8_t)~_BV(IMU_WAITS_BIT);
}

/* The burst that lies ready, before an interrupt begins it. */
static bool take(void)
{
    cli();
    const bool armed = (IDLE_FLAGS & _BV(IMU_ARMED_BIT)) != 0U;
    IDLE_FLAGS &= (uint8_t)~_BV(IMU_ARMED_BIT);
    sei();
    return armed;
}

/* --- steps --- */

static void wait_in(imu_t *it, uint8_t step, uint32_t now_us)
{
    it->step  = step;
    it->since = (uint8_t)(now_us >> 10);
}

static void lay_ready(imu_t *it, uint8_t step)
{
    const transfer_t *const transfer = &transfers[step];
    uint8_t                 reg      = pgm_read_byte(&transfer->reg);

    it->step = step;
    if (step == BURST && it->mode == MPU6050_TRIM) { reg = MPU6050_SELF_TEST_X; }
    twi_ready(pgm_read_byte(&transfer->sla), reg, (uint8_t *)it + pgm_read_byte(&transfer->at),
              pgm_read_byte(&transfer->len));
}

static void go(imu_t *it, uint8_t step)
{
    lay_ready(it, step);
    twi_go();
}

static void arm(imu_t *it)
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

/* The part is not what it was. */
static void lose(imu_t *it)
{
    pace(false);
    if (it->step >= GUARD) { port_count(&it->counters.losses); }
}

void mpu6050_motion_start(uint8_t mode)
{
    imu.mode     = mode;
    imu.is_asked = true;
}

static void begin(imu_t *it)
{
    pace(false);
    it->is_asked = false;
    it->step     = OFF;
    if (it->mode == MPU6050_OFF) { return; }
    for (uint8_t at = 0; at < RATES_LEN; at++) {
        it->settings[at] = pgm_read_byte(&modes[it->mode - 1U][at]);
    }
    it->period = (uint16_t)(PERIOD << it->settings[0]) + PATIENCE;
    twi_init();
    IMU_PORT |= _BV(IMU_INT); /* an open line is quiet */
    PCMSK2 = _BV(IMU_PCINT);
    go(it, IDENTIFY);
}

/* Bytes into words; false: all are 0. */
static bool read_burst(const imu_t *it, mpu6050_sample_t *sample)
{
    const uint8_t *byte = it->burst;
    uint8_t       *to   = (uint8_t *)sample;
    uint8_t        any  = 0;

    for (uint8_t left = WORDS; left != 0U; left--) {
        const uint8_t high = *byte++;
        const uint8_t low  = *byte++;
        *to++              = low;
        *to++              = high;
        any |= high | low;
    }
    return any != 0U;
}

/* What is waited for; the bus is free. */
static void look(imu_t *it, uint32_t now_us)
{
    const uint8_t waited = (uint8_t)((uint8_t)(now_us >> 10) - it->since);

    if (it->step == SETTLE && waited >= SETTLE_TIME) {
        it->guard_left = 1;
        arm(it);
        pace(true);
    } else if (it->step == ABSENT && waited >= RETRY_TIME) {
        go(it, IDENTIFY);
    }
}

/* The transfer of a step has come to its good end; true: the burst may be handed on. */
static bool go_on(imu_t *it, mpu6050_sample_t *sample, uint32_t now_us)
{
    switch (it->step) {
    case BURST:
        it->guard_left--;
        if (it->guard_left == 0U) {
            go(it, GUARD);
            return false;
        }
        it->guard = it->settings[GUARDED];
        break;
    case GUARD: it->guard_left = GUARD_EVERY; break;
    case SET_RATES: wait_in(it, SETTLE, now_us); return false;
    default: go(it, (uint8_t)(it->step + 1U)); return false;
    }
    if (!read_burst(it, sample) || it->guard != it->settings[GUARDED]) {
        lose(it);
        go(it, WAKE);
        return false;
    }
    const uint16_t age = (uint16_t)(((uint16_t)now_us << 1) + EARLY_MOST - it->due);
    sample->device_us  = now_us + EARLY_MOST / 2 - (age >> 1);
    arm(it);
    return true;
}

bool mpu6050_motion_poll(mpu6050_sample_t *sample, uint32_t now_us)
{
    imu_t *const it     = PORT_REACH(&imu);
    uint8_t      status = TWI_IDLE;

    if (it->is_lent) { return false; }
    if ((IDLE_FLAGS & _BV(IMU_ARMED_BIT)) != 0U && !it->is_asked) { return false; }
    if (!take()) { status = twi_poll(now_us); }
    if (status == TWI_BUSY) { return false; }
    if (it->is_asked) {
        begin(it);
    } else if (it->step >= SETTLE) {
        look(it, now_us);
    } else if (status == TWI_IDLE) {
        return go_on(it, sample, now_us);
    } else {
        lose(it);
        wait_in(it, ABSENT, now_us);
    }
    return false;
}

bool mpu6050_lend(uint8_t sla, uint8_t reg, uint8_t *buffer, uint8_t len, uint32_t now_us)
{
    imu_t *const it = PORT_REACH(&imu);

    if (it->step < SETTLE) {
        const uint16_t since_due = (uint16_t)(((uint16_t)now_us << 1) - it->due);
        if (it->step != BURST || since_due > LEND_TIME || !take()) { return false; }
    }
    it->is_lent = true;
    twi_ready(sla, reg, buffer, len);
    twi_go();
    return true;
}

void mpu6050_give_back(void)
{
    imu_t *const it = PORT_REACH(&imu);

    it->is_lent = false;
    if (it->step == BURST) { arm(it); }
}

mpu6050_state_t mpu6050_state(void)
{
    const uint8_t step = imu.step;

    if (step == IDENTIFY || step >= ABSENT) { return MPU6050_ABSENT; }
    return step == BURST || step == GUARD ? MPU6050_RUNNING : MPU6050_STARTING;
}

uint8_t mpu6050_identity(void)
{
    return imu.identity;
}

mpu6050_counters_t mpu6050_counters(void)
{
    cli();
    const mpu6050_counters_t now = imu.counters;
    sei();
    return now;
}
