/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads every conversion by polling and sends it: 4 bytes, big end first: 24 bits and, in the low
 * byte, DOUT after pulse 25. `extra_pulses` adds to the 25, `hold` stops reading, `power_down`
 * holds PD_SCK high, `hang` 1 loops and 2 sleeps for ever; the test pokes them. */
#include <avr/io.h>
#include <avr/wdt.h>

volatile uint8_t extra_pulses, hold, power_down, hang;
volatile uint8_t reset_flags;

static void put(uint8_t byte)
{
    while (!(UCSR0A & _BV(UDRE0))) {}
    UDR0 = byte;
}

static uint8_t pulse(void)
{
    PORTD |= _BV(PD3);
    __asm__ volatile("nop\n\tnop");
    PORTD &= (uint8_t)~_BV(PD3);
    return PIND & _BV(PD2) ? 1 : 0;
}

int main(void)
{
    reset_flags = MCUSR;
    MCUSR       = 0;
    wdt_disable();
    DDRD   = _BV(PD3);
    PORTD  = _BV(PD2);
    UCSR0A = _BV(U2X0);
    UBRR0  = 16;
    UCSR0B = _BV(TXEN0);
    for (;;) {
        if (hang) {
            wdt_enable(WDTO_15MS);
            while (hang == 2) { /* interrupts are off: only the watchdog can end this sleep */
                SMCR = _BV(SE);
                __asm__ volatile("sleep");
            }
            for (;;) {}
        }
        if (power_down) {
            PORTD |= _BV(PD3);
            while (power_down) {}
            PORTD &= (uint8_t)~_BV(PD3);
        }
        if (hold || PIND & _BV(PD2)) { continue; }
        uint32_t frame = 0;
        for (uint8_t i = 0; i < 24; i++) { frame = frame << 1 | pulse(); }
        const uint8_t check = pulse();
        for (uint8_t i = 0; i < extra_pulses; i++) { pulse(); }
        put((uint8_t)(frame >> 16));
        put((uint8_t)(frame >> 8));
        put((uint8_t)frame);
        put(check);
    }
}
