/* SPDX-License-Identifier: MIT */
#include "idle.h"

#include "port_reach.h"

#include <avr/interrupt.h>
#include <avr/sleep.h>

/* Written by the interrupt that ends a sleep, read by idle_sleep after it. */
static volatile uint16_t woken_tick;

static uint32_t slept_ticks;

void idle_init(void)
{
    SMCR       = _BV(SE); /* idle: timers, USART and external edges go on */
    IDLE_FLAGS = 0;
    sei();
}

/* Spoils r24, r25 and no more, which gcc would not promise: idle_interrupted relies on it. */
void idle_note_waking(void) __attribute__((naked, used));

void idle_note_waking(void)
{
    __asm__ volatile(
        "sbis %[flags], %[asleep]\n\t"
        "ret\n\t"
        "lds r24, %[count]\n\t" /* low byte first: it latches the high one */
        "lds r25, %[count] + 1\n\t"
        "sts %[tick], r24\n\t"
        "sts %[tick] + 1, r25\n\t"
        "cbi %[flags], %[asleep]\n\t"
        "ret" ::[flags] "I"(_SFR_IO_ADDR(IDLE_FLAGS)),
        [asleep] "I"(IDLE_ASLEEP_BIT), [count] "n"(_SFR_MEM_ADDR(TCNT1)), [tick] "i"(&woken_tick)
        : "memory");
}

void idle_sleep(void)
{
    uint16_t slept = 0; /* the timer's overflow ends the loop: less than its period */

    for (;;) {
        cli();
        if ((IDLE_FLAGS & _BV(IDLE_WORK_BIT)) != 0U) { break; }
        const uint16_t since = TCNT1;
        IDLE_FLAGS |= _BV(IDLE_ASLEEP_BIT);
        sei();
        sleep_cpu();
        /* Every interrupt clears the flag, so no later one writes woken_tick. */
        slept += (uint16_t)(woken_tick - since);
    }
    sei();
    *PORT_REACH(&slept_ticks) += slept;
}

uint32_t idle_take_slept_ticks(void)
{
    uint32_t *const total = PORT_REACH(&slept_ticks);
    const uint32_t  slept = *total;

    *total = 0;
    return slept;
}
