/* SPDX-License-Identifier: GPL-3.0-or-later */
/* twi - two-wire master, as in the ATmega328P datasheet, section 22.
 *
 * Model     START, repeated START, address, data and STOP take their true bit times
 *           (TWBR, TWPS); TWINT is a level that only the program clears, by writing one
 * Devices   up to TWI_DEVICES; each answers its address and is told of writes, reads and STOP.
 *           With none, every address is refused (NACK)
 * Lines     SDA = PC4, SCL = PC5, with pull-ups on the board; a line that is stuck low holds the
 *           bus, loses arbitration or reads as zeros; the program sees both in PINC and, with the
 *           TWI off, can clock SCL by DDRC
 * Bad data  no other master, no clock stretching, no slave mode
 */
#ifndef TWI_H
#define TWI_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/avr_twi.h>

#include "uno.h"

struct uno;

enum { TWI_DEVICES = 4 };

typedef struct {
    void   *ctx;
    uint8_t address;                        /* 7 bits */
    bool (*start)(void *ctx, bool reading); /* true: acknowledged */
    bool (*write)(void *ctx, uint8_t byte); /* true: acknowledged */
    uint8_t (*read)(void *ctx);
} twi_device_t;

/* A file of 256 registers: the first byte written sets the pointer, which then counts on. */
typedef struct {
    uint8_t regs[256];
    uint8_t pointer;
    bool    pointer_set;
} twi_registers_t;

typedef struct {
    avr_twi_t      *simavr; /* lends its vector */
    uint8_t         phase;  /* what the bus is in the middle of */
    uint8_t         action; /* what is under way */
    bool            reading;
    bool            restart;  /* START follows the STOP under way */
    twi_device_t   *selected; /* NULL: nobody answered */
    twi_device_t    devices[TWI_DEVICES];
    uint8_t         device_count;
    twi_registers_t registers;
    twi_fault_t     fault;
    bool            scl; /* as the program left it with the TWI off */
} twi_t;

void twi_init(struct uno *uno);
void twi_after_reset(struct uno *uno);
/* false: there is no room for it. */
bool twi_attach(struct uno *uno, const twi_device_t *device);

#endif
