/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Critical sections of known length, a stack of known depth, and sleep. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

volatile uint8_t ticks;

ISR(TIMER0_OVF_vect)
{
    ticks++;
}

/* From the end of CLI to the end of SEI: 20 nop + 1. */
__attribute__((noinline)) void section_of_21(void)
{
    __asm__ volatile("cli\n\t.rept 20\n\tnop\n\t.endr\n\tsei");
}

/* SREG saved and restored: from the end of CLI 5 nop + out 1. */
__attribute__((noinline)) void section_of_6(void)
{
    __asm__ volatile("in r18, 0x3f\n\tcli\n\t.rept 5\n\tnop\n\t.endr\n\tout 0x3f, r18" : : : "r18");
}

__attribute__((noinline)) uint8_t deep(uint8_t n)
{
    volatile uint8_t frame[16];

    frame[0] = n;
    return (uint8_t)(n ? deep((uint8_t)(n - 1U)) + frame[0] : 0);
}

int main(void)
{
    TCCR0B = _BV(CS01); /* overflows every 2048 cycles */
    TIMSK0 = _BV(TOIE0);
    sei();
    deep(8);
    for (;;) {
        section_of_21();
        section_of_6();
        set_sleep_mode(SLEEP_MODE_IDLE);
        sleep_mode();
    }
}
