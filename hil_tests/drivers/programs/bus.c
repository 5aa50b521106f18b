/* SPDX-License-Identifier: MIT */
/* Reads an MPU-6050 in the mode MODE and a magnetometer beside it, and keeps their latest samples.
 * The main loop works WORK_CYCLES on each sample and WEIGH_CYCLES every 12.5 ms. */
#include "idle.h"
#include "magnetometer.h"
#include "mpu6050_motion.h"
#include "ticks.h"
#include "twi.h"
#include "uno_pins.h"

#include <avr/interrupt.h>
#include <util/delay_basic.h>

volatile uint32_t           sample_count, mag_count;
volatile int16_t            mag[3];
volatile uint16_t           mag_longest; /* between two readings, 1.024 ms */
volatile uint8_t            kind, state;
volatile mpu6050_counters_t counters;
volatile uint16_t           recoveries;
volatile uint16_t           stamp_longest; /* between two samples, us */
static volatile uint8_t     overflows;

/* As the image's other interrupts do: the main loop comes round every 4 ms. */
ISR(TIMER0_OVF_vect)
{
    idle_interrupted();
    overflows++;
    idle_post_work();
}

static void work(uint16_t cycles)
{
    if (cycles != 0U) { _delay_loop_2(cycles / 4U); }
}

static void look_at_field(void)
{
    static uint16_t before;
    int16_t         counts[3];
    const uint32_t  now_us = ticks_device_us();

    if (magnetometer_poll(counts, now_us)) {
        const uint16_t now = (uint16_t)(now_us >> 10);
        if (mag_count > 1U && (uint16_t)(now - before) > mag_longest) {
            mag_longest = (uint16_t)(now - before);
        }
        before = now;
        for (uint8_t axis = 0; axis < 3U; axis++) { mag[axis] = counts[axis]; }
        mag_count++;
    }
    kind = magnetometer_kind();
}

static void look_at_motion(void)
{
    static uint32_t  before_us;
    mpu6050_sample_t sample;
    const bool       has_come = mpu6050_motion_poll(&sample, ticks_device_us());

    look_at_field();
    if (!has_come) { return; }
    const uint32_t step_us = sample.device_us - before_us;
    if (sample_count != 0U && step_us > stamp_longest && step_us < 20000UL) {
        stamp_longest = (uint16_t)step_us;
    }
    before_us = sample.device_us;
    sample_count++;
    work(WORK_CYCLES);
    look_at_field();
}

int main(void)
{
    ticks_init();
    TCCR0B = _BV(CS02); /* 16 MHz / 256 */
    TIMSK0 = _BV(TOIE0);
    idle_init();
    mpu6050_motion_start(MODE);
    for (;;) {
        idle_clear_work();
        if (overflows >= 3U) {
            overflows = 0;
            work(WEIGH_CYCLES);
        }
        look_at_motion();
        state      = mpu6050_state();
        counters   = mpu6050_counters();
        recoveries = twi_recoveries;
        idle_sleep();
    }
}
