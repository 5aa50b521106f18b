/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Flag registers, late enabling, PIN toggling and the sleep race; results for the test to peek. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

volatile uint8_t flags_both, flags_after_out, flags_after_sbi;
volatile uint8_t late_entries, masked_entries, port_after_toggle, woke, done;
volatile uint8_t false_edges, real_edges;

ISR(TIMER0_OVF_vect)
{
    late_entries++;
}
ISR(PCINT0_vect)
{
    woke = 1;
}

static void two_flags(void) /* TOV1 and OCF1A of a timer in normal mode */
{
    TCCR1B = 0;
    TIFR1  = _BV(TOV1) | _BV(OCF1A);
    OCR1A  = 0x0010;
    TCCR1B = _BV(CS10);
    TCNT1  = 0xFFF0; /* after the start: simavr forgets what a stopped timer is given */
    while (!(TIFR1 & _BV(OCF1A))) {}
    TCCR1B = 0;
}

int main(void)
{
    two_flags();
    flags_both      = TIFR1 & (_BV(TOV1) | _BV(OCF1A));
    TIFR1           = _BV(TOV1);
    flags_after_out = TIFR1 & (_BV(TOV1) | _BV(OCF1A));
    two_flags();
    __asm__ volatile("sbi %0, %1" : : "I"(_SFR_IO_ADDR(TIFR1)), "I"(OCF1A));
    flags_after_sbi = TIFR1 & (_BV(TOV1) | _BV(OCF1A));

    TCCR0B = _BV(CS00); /* overflows while its interrupt is masked */
    while (!(TIFR0 & _BV(TOV0))) {}
    TCCR0B = 0;
    sei();
    __asm__ volatile("nop\n\tnop\n\tnop");
    masked_entries = late_entries;
    TIMSK0         = _BV(TOIE0); /* the flag is set already: must fire now */
    __asm__ volatile("nop\n\tnop\n\tnop");
    cli();

    DDRB  = 0x3F;
    PORTB = 0x15;
    __asm__ volatile("sbi %0, 5" : : "I"(_SFR_IO_ADDR(PINB)));
    port_after_toggle = PORTB;

    EICRA = _BV(ISC01); /* INT0 on falling edges; the part holds DOUT low now */
    PORTD = _BV(PD2);
    DDRD |= _BV(PD6);
    while (PIND & _BV(PD2)) {}
    EIFR = _BV(INTF0);
    for (uint8_t i = 0; i < 10; i++) { PORTD ^= _BV(PD6); }
    false_edges = EIFR & _BV(INTF0);
    DDRD |= _BV(PD3); /* clock a one and a zero out of 0x800000...: a real falling edge */
    for (uint8_t i = 0; i < 2; i++) {
        PORTD |= _BV(PD3);
        __asm__ volatile("nop\n\tnop\n\tnop");
        PORTD &= (uint8_t)~_BV(PD3);
    }
    __asm__ volatile("nop\n\tnop\n\tnop");
    real_edges = EIFR & _BV(INTF0);

    PCMSK0 = _BV(PCINT0);
    PCICR  = _BV(PCIE0);
    PORTB ^= _BV(PB0); /* pending before SEI: SLEEP must not be the last instruction ever */
    if (!woke) {
        sleep_enable();
        sei();
        sleep_cpu();
    }
    done = 1;
    for (;;) {}
}
