/* SPDX-License-Identifier: MIT */
/* twi - master of the two-wire bus at 400 kHz, one transfer at a time, moved by its interrupt.
 *
 * Model     a transfer writes a register's number, then writes bytes of a buffer, or reads into it
 *           after a repeated START; ATmega328P datasheet, ch. 21, tables 21-3, 21-4. It begins at
 *           once, or is laid ready for an interrupt to begin: see twi_ready
 * Formats   sla: 7 bits of address, then 1 to read, 0 to write    buffer: the caller's, in use
 *           until the transfer has ended
 * Waits     none: a transfer is begun and asked after. One that has not ended 2 to 3 ms after it
 *           was first seen under way is given up and the bus recovered, which takes the caller
 *           130 us at the most
 * Recovery  the TWI lets go; up to 20 clocks until SDA is high, so that a part that was reading
 *           shifts its byte out; STOP; the TWI takes over. A line that stays low leaves the bus as
 *           it is: the next transfer is given up as well
 * Bad data  an address or a byte not acknowledged, a bus error, arbitration lost: refused, with a
 *           STOP, at once; if a line is stuck, the next transfer is given up
 * Context   main loop; who begins what lies ready is an interrupt handler. TWI interrupt is the
 *           driver's own and posts work for the main loop when a transfer has ended.
 *           Cost: firmware/budget.toml
 */
#ifndef TWI_H
#define TWI_H

#include <avr/io.h>
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

/* Lay a transfer ready, while none is under way; len is at least 1. What lay ready is forgotten;
 * nobody may begin that meanwhile. */
void twi_ready(uint8_t sla, uint8_t reg, uint8_t *buffer, uint8_t len);

/* Begin what lies ready. An interrupt sets TWI_BUSY_BIT, then writes TWI_START to TWCR. */
#define TWI_START (_BV(TWINT) | _BV(TWEN) | _BV(TWIE) | _BV(TWSTA))
void twi_go(void);

/* How the last transfer that was begun stands; gives up one that takes too long.
 * now: twi_time. */
twi_status_t twi_poll(uint8_t now);

/* Time in units of 1.024 ms, for waits. */
static inline uint8_t twi_time(uint32_t now_us)
{
    return (uint8_t)((uint16_t)(now_us >> 8) >> 2);
}

#endif
