/* SPDX-License-Identifier: MIT */
#include "idle.h"

#include <avr/interrupt.h>
#include <avr/sleep.h>

volatile uint16_t idle_woken_tick;

static uint32_t slept_ticks;

void idle_init(void)
{
    SMCR       = 0; /* idle: timers, USART and external edges go on */
    IDLE_FLAGS = 0;
    sei();
}

void idle_sleep(void)
{
    for (;;) {
        cli();
        if ((IDLE_FLAGS & _BV(IDLE_WORK_BIT)) != 0U) { break; }
        const uint16_t since = TCNT1;
        IDLE_FLAGS |= _BV(IDLE_ASLEEP_BIT);
        sleep_enable();
        sei();
        sleep_cpu();
        sleep_disable();
        /* Every interrupt clears the flag, so no later one writes idle_woken_tick. A sleep is
         * shorter than the timer's period, because the timer's overflow ends it. */
        slept_ticks += (uint16_t)(idle_woken_tick - since);
    }
    sei();
}

uint32_t idle_take_slept_ticks(void)
{
    const uint32_t slept = slept_ticks;

    slept_ticks = 0;
    return slept;
}
