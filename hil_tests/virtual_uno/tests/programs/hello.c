/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Says the cause of its reset and then counts for ever, without a pause; echoes what it is sent
 * in capitals. */
#include <avr/io.h>
#include <avr/wdt.h>

static void put(uint8_t byte)
{
    while (!(UCSR0A & _BV(UDRE0))) {}
    UDR0 = byte;
}

int main(void)
{
    const uint8_t cause = MCUSR;

    MCUSR = 0;
    wdt_disable();
    UCSR0A = _BV(U2X0);
    UBRR0  = 16;
    UCSR0B = _BV(RXEN0) | _BV(TXEN0);
    put('<');
    put((uint8_t)('0' + cause));
    put('>');
    for (uint8_t n = 0;; n++) {
        put('a' + n % 26);
        if (UCSR0A & _BV(RXC0)) { put(UDR0 & 0xDF); }
    }
}
