/* SPDX-License-Identifier: GPL-3.0-or-later */
/* USART at 115200 (UBRR 16, U2X): a burst, then an echo of status and data when told to look. */
#include <avr/io.h>

volatile uint8_t look; /* set by the test: read what has come */
volatile uint8_t received[8], status[8], count;

static void put(uint8_t byte)
{
    while (!(UCSR0A & _BV(UDRE0))) {}
    UDR0 = byte;
}

int main(void)
{
    UCSR0A = _BV(U2X0);
    UBRR0  = 16;
    UCSR0B = _BV(RXEN0) | _BV(TXEN0);
    for (uint8_t i = 0; i < 8; i++) { put((uint8_t)(0x55 + i)); }
    UDR0 = 0xEE; /* buffer full: ignored by the chip */
    for (;;) {
        if (!look) { continue; }
        count = 0;
        while (count < 8) {
            const uint8_t a = UCSR0A;
            if (!(a & _BV(RXC0))) { break; }
            status[count]   = a & (_BV(FE0) | _BV(DOR0));
            received[count] = UDR0;
            count++;
        }
        look = 0;
    }
}
