/* SPDX-License-Identifier: GPL-3.0-or-later */
/* TWI master at 100 kHz: an absent address, then a write to and a read from registers at 0x68.
 * PD3 is high from START to its status; results are for the test to peek. */
#include <avr/io.h>

volatile uint8_t status[12], data[2], done;

static uint8_t step(uint8_t control)
{
    TWCR = _BV(TWINT) | _BV(TWEN) | control;
    while (!(TWCR & _BV(TWINT))) {}
    return TWSR & 0xF8;
}

static void stop(void)
{
    TWCR = _BV(TWINT) | _BV(TWEN) | _BV(TWSTO);
    while (TWCR & _BV(TWSTO)) {}
}

static uint8_t send(uint8_t byte)
{
    TWDR = byte;
    PORTD |= _BV(PD3);
    const uint8_t code = step(0);
    PORTD &= (uint8_t)~_BV(PD3);
    return code;
}

int main(void)
{
    DDRD |= _BV(PD3);
    TWBR      = 72; /* 16 + 2 * 72 = 160 cycles a bit */
    status[0] = step(_BV(TWSTA));
    status[1] = send(0x3C << 1);
    stop();
    status[2]  = step(_BV(TWSTA));
    status[3]  = send(0x68 << 1);
    status[4]  = send(0x10);
    status[5]  = send(0xC3);
    status[6]  = step(_BV(TWSTA));
    status[7]  = send(0x68 << 1);
    status[8]  = send(0x0F);
    status[9]  = step(_BV(TWSTA));
    status[10] = send(0x68 << 1 | 1);
    status[11] = step(_BV(TWEA));
    data[0]    = TWDR;
    step(0);
    data[1] = TWDR;
    stop();
    done = 1;
    for (;;) {}
}
