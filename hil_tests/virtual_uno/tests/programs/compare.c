/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Timer1 runs free at 2 MHz; its compare A is set anew by each of its interrupts, or put off. */
#include <avr/interrupt.h>
#include <avr/io.h>

volatile uint16_t step = 2048, first = 0; /* of 2^16 a divisor: 0 is one of the values */
volatile uint16_t calls, at_zero, late_most, overflows;
volatile uint8_t  go, put_off;

ISR(TIMER1_COMPA_vect)
{
    const uint16_t at   = OCR1A;
    const uint16_t late = (uint16_t)(TCNT1 - at);

    if (late > late_most) { late_most = late; }
    if (at == 0) { at_zero++; }
    calls++;
    OCR1A = at + step;
}

ISR(TIMER1_OVF_vect)
{
    overflows++;
}

int main(void)
{
    while (!go) {}
    TCCR1B = _BV(CS11);
    OCR1A  = first + step;
    TIFR1  = _BV(OCF1A); /* the compare of before */
    TIMSK1 = _BV(TOIE1) | _BV(OCIE1A);
    sei();
    for (;;) {
        cli();
        if (put_off) { OCR1A = (uint16_t)(TCNT1 + 200); }
        sei();
        __asm__ volatile("nop\n\tnop"); /* an interrupt may come behind the first */
    }
}
