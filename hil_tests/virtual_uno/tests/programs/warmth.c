/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Wakes an MPU-6050, then says its temperature in raw counts as a decimal line, ten a second;
 * `none` where nobody answers. */
#include <avr/io.h>
#include <stdlib.h>
#include <util/delay.h>

static uint8_t step(uint8_t control)
{
    TWCR = _BV(TWINT) | _BV(TWEN) | control;
    while (!(TWCR & _BV(TWINT))) {}
    return TWSR;
}

static uint8_t send(uint8_t byte)
{
    TWDR = byte;
    return step(0);
}

static void stop(void)
{
    TWCR = _BV(TWINT) | _BV(TWEN) | _BV(TWSTO);
    while (TWCR & _BV(TWSTO)) {}
}

static void say(const char *text)
{
    for (; *text; text++) {
        while (!(UCSR0A & _BV(UDRE0))) {}
        UDR0 = (uint8_t)*text;
    }
}

int main(void)
{
    char text[8];

    UCSR0A = _BV(U2X0);
    UBRR0  = 16;
    UCSR0B = _BV(TXEN0);
    TWBR   = 12;
    for (;;) {
        step(_BV(TWSTA));
        if (send(0x68 << 1) != 0x18) {
            stop();
            say("none\n");
        } else {
            send(0x6B);
            send(1);
            stop();
            _delay_ms(100);
            step(_BV(TWSTA));
            send(0x68 << 1);
            send(0x41);
            step(_BV(TWSTA));
            send(0x68 << 1 | 1);
            step(_BV(TWEA));
            const uint8_t high = TWDR;
            step(0);
            say(itoa((int16_t)(high << 8 | TWDR), text, 10));
            say("\n");
            stop();
        }
        _delay_ms(100);
    }
}
