/* SPDX-License-Identifier: MIT */
/* Reads an MPU-6050 in the mode `mode`, first MODE; keeps the latest samples. */
#include "idle.h"
#include "mpu6050_motion.h"
#include "ticks.h"
#include "twi.h"
#include "uno_pins.h"

#include <avr/interrupt.h>

enum { KEPT = 16 };

volatile mpu6050_sample_t   samples[KEPT];
volatile uint32_t           sample_count;
volatile uint8_t            state, identity;
volatile mpu6050_counters_t counters;
volatile uint16_t           recoveries;
volatile int16_t            temperature_centi;
volatile uint8_t            mode = MODE;

/* As the image's other interrupts do: the main loop comes round every 4 ms. */
ISR(TIMER0_OVF_vect)
{
    idle_interrupted();
    idle_post_work();
}

static void look(void)
{
    state      = mpu6050_state();
    identity   = mpu6050_identity();
    counters   = mpu6050_counters();
    recoveries = twi_recoveries;
}

int main(void)
{
    uint8_t chosen = MPU6050_OFF;

    ticks_init();
    TCCR0B = _BV(CS02); /* 16 MHz / 256 */
    TIMSK0 = _BV(TOIE0);
    idle_init();
    for (;;) {
        idle_clear_work();
        mpu6050_sample_t sample;
        if (mode != chosen) {
            chosen = mode;
            mpu6050_motion_start(chosen);
        }
        if (mpu6050_motion_poll(&sample, ticks_device_us())) {
            temperature_centi            = mpu6050_temperature_centi(sample.temp_counts);
            samples[sample_count % KEPT] = sample;
            sample_count++;
        }
        look();
        idle_sleep();
    }
}
