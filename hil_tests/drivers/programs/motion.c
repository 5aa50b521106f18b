/* SPDX-License-Identifier: MIT */
/* Reads an MPU-6050 at the setup SETUP, paced by its INT line at D4; keeps the latest samples. With
 * `judge` set it judges a self-test instead. */
#include "idle.h"
#include "mpu6050_motion.h"
#include "ticks.h"
#include "twi.h"
#include "uno_pins.h"

#include <avr/interrupt.h>

enum { KEPT = 16 };

volatile mpu6050_sample_t   samples[KEPT];
volatile uint32_t           count;
volatile uint8_t            state, identity;
volatile mpu6050_counters_t counters;
volatile uint16_t           recoveries;
volatile int16_t            temperature_centi;

volatile uint8_t trim[4], judge, passes;
volatile int16_t answer[7];

ISR(PCINT2_vect)
{
    if ((PIND & _BV(PD4)) == 0U) { return; } /* its end */
    const uint32_t now_us = ticks_device_us_in_isr();
    idle_interrupted();
    mpu6050_motion_due(now_us);
}

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
    if (judge) {
        passes = mpu6050_self_test_passes((const uint8_t *)trim, (const int16_t *)answer);
        judge  = 0;
    }
}

int main(void)
{
    ticks_init();
    mpu6050_init(&SETUP);
    PCMSK2 = _BV(PCINT20);
    PCICR  = _BV(PCIE2);
    TCCR0B = _BV(CS02); /* 16 MHz / 256 */
    TIMSK0 = _BV(TOIE0);
    idle_init();
    for (;;) {
        idle_clear_work();
        mpu6050_sample_t sample;
        if (mpu6050_motion_poll(&sample, ticks_device_us())) {
            const uint8_t temp_out[2] = {(uint8_t)((uint16_t)sample.temp_counts >> 8),
                                         (uint8_t)sample.temp_counts};
            temperature_centi         = mpu6050_temperature_centi(temp_out);
            samples[count % KEPT]     = sample;
            count++;
        }
        look();
        idle_sleep();
    }
}
