/* SPDX-License-Identifier: MIT */
#include "ticks.h"

#include "idle.h"
#include "uno_pins.h"

#include <avr/interrupt.h>
#include <avr/io.h>

/* Written by the overflow interrupt, read by everybody with interrupts off. Multiples of 32768. */
static volatile uint32_t overflow_us;

ISR(TIMER1_OVF_vect)
{
    idle_interrupted();
    overflow_us += 32768UL;
    idle_post_work(); /* time-outs and seconds are looked at, even on a silent line */
}

void ticks_init(void)
{
    TCCR1B = 0; /* a boot loader may have left the timer running */
    TCCR1A = 0;
    TCNT1  = 0;
    TIFR1  = _BV(TOV1);
    TCCR1B = _BV(CS11); /* clk / 8 */
    TIMSK1 = _BV(TOIE1);
}

/* An overflow whose interrupt still waits is seen by its flag; the counter is then small. It is
 * large if the overflow came after the counter was read, and then must not be added. */
static inline uint32_t joined_us(uint16_t tick, uint8_t flags, uint32_t base_us)
{
    if ((flags & _BV(TOV1)) != 0U && tick < 0x8000U) { base_us += 32768UL; }
    return base_us + (tick >> 1);
}

uint32_t ticks_device_us_in_isr(void)
{
    const uint16_t tick  = TCNT1;
    const uint8_t  flags = TIFR1;

    return joined_us(tick, flags, overflow_us);
}

uint32_t ticks_device_us(void)
{
    const uint8_t sreg = SREG;

    cli();
    const uint16_t tick    = TCNT1;
    const uint8_t  flags   = TIFR1;
    const uint32_t base_us = overflow_us;
    SREG                   = sreg;
    return joined_us(tick, flags, base_us);
}
