/* SPDX-License-Identifier: GPL-3.0-or-later */
/* TWI master at 400 kHz on behalf of a test: writes `write_len` bytes of `buffer` to `address`,
 * then reads `read_len` bytes into it. `go` is cleared when done; `failed` is the first status that
 * is not the one hoped for, or 0; `cycles` is how long it took from START to STOP. */
#include <avr/io.h>

volatile uint8_t  address, buffer[32], write_len, read_len, go, failed;
volatile uint16_t cycles;

static void step(uint8_t control, uint8_t wanted)
{
    TWCR = _BV(TWINT) | _BV(TWEN) | control;
    while (!(TWCR & _BV(TWINT))) {}
    if (!failed && (TWSR & 0xF8) != wanted) { failed = TWSR & 0xF8; }
}

static void transfer(void)
{
    step(_BV(TWSTA), 0x08);
    if (write_len) {
        TWDR = (uint8_t)(address << 1);
        step(0, 0x18);
        for (uint8_t i = 0; i < write_len && !failed; i++) {
            TWDR = buffer[i];
            step(0, 0x28);
        }
        if (read_len && !failed) { step(_BV(TWSTA), 0x10); }
    }
    if (read_len && !failed) {
        TWDR = (uint8_t)(address << 1 | 1);
        step(0, 0x40);
        for (uint8_t i = 0; i < read_len && !failed; i++) {
            if (i + 1 < read_len) {
                step(_BV(TWEA), 0x50);
            } else {
                step(0, 0x58);
            }
            buffer[i] = TWDR;
        }
    }
    TWCR = _BV(TWINT) | _BV(TWEN) | _BV(TWSTO);
    while (TWCR & _BV(TWSTO)) {}
}

int main(void)
{
    TWBR   = 12; /* 16 + 2 * 12 = 40 cycles a bit */
    TCCR1B = _BV(CS10);
    for (;;) {
        while (!go) {}
        failed = 0;
        TCNT1  = 0;
        transfer();
        cycles = TCNT1;
        go     = 0;
    }
}
