/* SPDX-License-Identifier: MIT */
#include "mpu6050.h"

#include "mpu6050_registers.h"
#include "twi.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <stddef.h>

/* A step is the transfer under way or the wait; 1..pair_count write that pair. */
enum {
    STEP_IDENTIFY = 0,
    STEP_SETTLE   = 0xFB,
    STEP_READY, /* this and what follows: running */
    STEP_BURST,
    STEP_GUARD,
    STEP_ABSENT
};

/* In units of 1.024 ms. */
enum { SILENCE_TIME = 8, SETTLE_TIME = 35, RETRY_TIME = 244 };

static const mpu6050_setup_t *setup;       /* in program memory */
static volatile uint8_t       step;        /* a request writes, where it is READY */
static uint8_t *volatile wanted;           /* a request writes: its burst waits; or NULL */
static volatile uint16_t overruns, losses; /* a request writes the first */
static uint8_t           control[2];       /* what a step writes, then what it has read */
static uint8_t           guard_left;       /* bursts until the guard is read; 0: one waits for it */
static uint8_t           identity;
static uint16_t          since; /* when a wait began or a burst came, 1.024 ms */

static void count(volatile uint16_t *counter)
{
    if (*counter != UINT16_MAX) { (*counter)++; }
}

static uint8_t of_setup(size_t offset)
{
    return pgm_read_byte((const uint8_t *)setup + offset);
}

/* A pair's register or, one further, its value; pairs count from 1. */
static uint8_t of_pair(uint8_t pair, uint8_t which)
{
    return of_setup(offsetof(mpu6050_setup_t, pairs) - 2U + 2U * pair + which);
}

static void wait_in(uint8_t waiting_step, uint32_t now_us)
{
    step   = waiting_step;
    since  = (uint16_t)(now_us >> 10);
    wanted = NULL;
}

/* Begin the transfer of a step that concerns one register. */
static void go(uint8_t next_step, uint32_t now_us)
{
    uint8_t pair     = next_step;
    uint8_t read_len = 0;

    step = next_step;
    if (next_step == STEP_GUARD) {
        pair     = of_setup(offsetof(mpu6050_setup_t, pair_count));
        read_len = 1;
    }
    control[0] = of_pair(pair, 0);
    control[1] = of_pair(pair, 1);
    if (next_step == STEP_IDENTIFY) {
        control[0] = MPU6050_WHO_AM_I_REG;
        read_len   = 1;
    }
    twi_begin(MPU6050_ADDRESS, control, (uint8_t)(2U - read_len), read_len, now_us);
}

static void begin_burst(uint8_t *burst, uint32_t now_us)
{
    step     = STEP_BURST;
    burst[0] = of_setup(offsetof(mpu6050_setup_t, first_register));
    twi_begin(MPU6050_ADDRESS, burst, 1, of_setup(offsetof(mpu6050_setup_t, burst_len)), now_us);
}

static void make_ready(uint32_t now_us)
{
    since = (uint16_t)(now_us >> 10);
    step  = STEP_READY;
    cli(); /* a request may come in between and find it ready */
    if (step == STEP_READY && wanted != NULL) {
        begin_burst(wanted, now_us);
        wanted = NULL;
    }
    sei();
}

void mpu6050_init(const mpu6050_setup_t *chosen)
{
    setup = chosen;
    twi_init();
    go(STEP_IDENTIFY, 0);
}

bool mpu6050_request(uint8_t *burst, uint32_t now_us)
{
    if (step == STEP_READY) {
        begin_burst(burst, now_us);
        return true;
    }
    if (mpu6050_state() != MPU6050_RUNNING) { return false; }
    if (wanted != NULL) {
        count(&overruns);
        return false;
    }
    wanted = burst;
    return true;
}

/* The transfer of that step has come to its good end; true: a burst is there. */
static bool go_on(uint8_t done, uint32_t now_us)
{
    const uint8_t pair_count = of_setup(offsetof(mpu6050_setup_t, pair_count));
    bool          is_burst   = true;

    switch (done) {
    case STEP_IDENTIFY:
        identity = control[0];
        go(1, now_us);
        return false;
    case STEP_BURST:
        guard_left--;
        if (guard_left == 0U) {
            go(STEP_GUARD, now_us);
            return false;
        }
        break;
    case STEP_GUARD:
        is_burst   = guard_left == 0U;
        guard_left = of_setup(offsetof(mpu6050_setup_t, guard_every));
        if (control[0] != of_pair(pair_count, 1)) {
            count(&losses);
            go(1, now_us);
            wanted = NULL; /* from now on no request writes it */
            return false;
        }
        break;
    default:
        if (done == pair_count) {
            guard_left = 1;
            wait_in(STEP_SETTLE, now_us);
        } else {
            go((uint8_t)(done + 1U), now_us);
        }
        return false;
    }
    make_ready(now_us);
    return is_burst;
}

/* Nobody asks any more: perhaps because the part tells of no data. */
static void look_after(uint32_t now_us)
{
    cli(); /* a request may come in between */
    if (step == STEP_READY) { go(STEP_GUARD, now_us); }
    sei();
}

bool mpu6050_poll(uint32_t now_us)
{
    const uint8_t      at     = step; /* before the bus: a request in between has begun a burst */
    const twi_status_t status = twi_poll(now_us);
    const uint16_t     waited = (uint16_t)((uint16_t)(now_us >> 10) - since);

    if (status == TWI_BUSY) { return false; }
    if (at == STEP_READY) {
        if (waited >= SILENCE_TIME) { look_after(now_us); }
    } else if (at == STEP_ABSENT) {
        if (waited >= RETRY_TIME) { go(STEP_IDENTIFY, now_us); }
    } else if (at == STEP_SETTLE) {
        if (waited >= SETTLE_TIME) { make_ready(now_us); }
    } else if (status == TWI_IDLE) {
        return go_on(at, now_us);
    } else {
        if (at >= STEP_READY) { count(&losses); }
        wait_in(STEP_ABSENT, now_us);
    }
    return false;
}

mpu6050_state_t mpu6050_state(void)
{
    const uint8_t now = step;

    if (now == STEP_IDENTIFY || now == STEP_ABSENT) { return MPU6050_ABSENT; }
    return now >= STEP_READY ? MPU6050_RUNNING : MPU6050_STARTING;
}

uint8_t mpu6050_identity(void)
{
    return identity;
}

mpu6050_counters_t mpu6050_counters(void)
{
    cli();
    const mpu6050_counters_t now = {.overruns = overruns, .losses = losses};
    sei();
    return now;
}

int16_t mpu6050_temperature_centi(const uint8_t temp_out[2])
{
    const int16_t raw = (int16_t)(((uint16_t)temp_out[0] << 8) | temp_out[1]);

    /* 1 / 3.4 = 19275 / 2^16, short by 1.5e-5 of it */
    return (int16_t)(((raw * 19275L + 0x8000L) >> 16) + 3653);
}
