/* SPDX-License-Identifier: MIT */
/* twi - master of the two-wire bus at 400 kHz, one transfer at a time, moved by its interrupt.
 *
 * Model     a transfer writes write_len bytes of a buffer, then, after a repeated START, reads
 *           read_len bytes into the same buffer; ATmega328P datasheet, ch. 21, tables 21-3, 21-4
 * Formats   address: 7 bits    buffer: the caller's, in use until the transfer has ended
 * Waits     none: a transfer is begun and asked after. One that has not ended within 2 ms is given
 *           up and the bus recovered, which takes the caller 130 us at the most
 * Recovery  the TWI lets go; up to 20 clocks until SDA is high, so that a part that was reading
 *           shifts its byte out; STOP; the TWI takes over. A line that stays low leaves the bus as
 *           it is: the next transfer is given up as well
 * Bad data  an address or a byte not acknowledged, a bus error, arbitration lost: refused, with a
 *           STOP, at once; if a line is stuck, the next transfer is given up
 * Context   main loop, and interrupt handlers for twi_begin; TWI interrupt is the driver's own and
 *           posts work for the main loop when a transfer has ended.  Cost: firmware/budget.toml
 */
#ifndef TWI_H
#define TWI_H

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    TWI_IDLE,    /* the last transfer, if any, was done */
    TWI_BUSY,    /* under way */
    TWI_REFUSED, /* ended early: nobody there, or a spike on the line */
    TWI_FAILED   /* given up, the bus was recovered */
} twi_status_t;

/* Since reset; it stops at its maximum. */
extern uint8_t twi_recoveries;

/* Take the lines, pull-ups on. */
void twi_init(void);

/* Begin a transfer; false, and nothing is done, while another is under way. write_len is at least
 * 1. now_us is where its time begins. */
bool twi_begin(uint8_t address, uint8_t *buffer, uint8_t write_len, uint8_t read_len,
               uint32_t now_us);

/* How the transfer stands; gives up one that takes too long. */
twi_status_t twi_poll(uint32_t now_us);

#endif
