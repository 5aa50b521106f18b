/* SPDX-License-Identifier: MIT */
#include "twi.h"

#include "idle.h"
#include "port_reach.h"
#include "uno_pins.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/delay.h>

/* Status codes, ATmega328P datasheet, tables 21-3 and 21-4; the prescaler's bits are 0. */
enum {
    START       = 0x08,
    RESTART     = 0x10,
    WRITE_ACKED = 0x18,
    SENT_ACKED  = 0x28,
    READ_ACKED  = 0x40,
    GOT_MORE    = 0x50,
    GOT_LAST    = 0x58
};

enum {
    BIT_RATE        = (F_CPU / 400000UL - 16UL) / 2UL, /* datasheet, 21.5.2 */
    RECOVERY_CLOCKS = 20,                              /* 9 by the standard; some parts need more */
    TIMEOUT_US      = 2000, /* 16 bytes take 0.4 ms, and interrupts hold each back */
    GO              = _BV(TWINT) | _BV(TWEN) | _BV(TWIE)
};

#define HALF_CLOCK_US 2.5

uint8_t twi_recoveries;

typedef struct {
    volatile uint8_t  state; /* twi_status_t; twi_begin and the interrupt write, twi_poll reads */
    uint8_t           sla;   /* address and direction */
    uint8_t          *first, *next; /* of the buffer */
    uint8_t           write_left, read_left;
    volatile uint16_t begun_us; /* twi_begin writes, where nothing is under way; twi_poll reads */
} bus_t;

static bus_t bus;

ISR(TWI_vect)
{
    idle_interrupted();
    bus_t *const it      = PORT_REACH(&bus);
    uint8_t     *at      = it->next;
    uint8_t      control = GO;

    switch (TWSR) {
    case START:
    case RESTART: TWDR = it->sla; break;
    case WRITE_ACKED:
    case SENT_ACKED:
        if (it->write_left != 0U) {
            it->write_left--;
            TWDR = *at++;
        } else if (it->read_left != 0U) {
            it->sla |= 1U;
            at = it->first;
            control |= _BV(TWSTA);
        } else {
            it->state = TWI_IDLE;
        }
        break;
    case GOT_MORE:
    case GOT_LAST:
        *at++ = TWDR;
        if (it->read_left == 0U) {
            it->state = TWI_IDLE;
            break;
        } /* fall through */
    case READ_ACKED:
        it->read_left--;
        if (it->read_left != 0U) { control |= _BV(TWEA); }
        break;
    default: it->state = TWI_REFUSED; break; /* not acknowledged; bus error, arbitration lost */
    }
    it->next = at;
    if (it->state != TWI_BUSY) {
        control = _BV(TWINT) | _BV(TWEN) | _BV(TWSTO);
        idle_post_work();
    }
    TWCR = control;
}

static void scl_low(void)
{
    TWI_PORT &= (uint8_t)~_BV(TWI_SCL);
    TWI_DDR |= _BV(TWI_SCL);
    _delay_us(HALF_CLOCK_US);
}

static void scl_release(void)
{
    TWI_DDR &= (uint8_t)~_BV(TWI_SCL);
    TWI_PORT |= _BV(TWI_SCL);
    _delay_us(HALF_CLOCK_US);
}

static void recover(void)
{
    TWCR = 0; /* lets go of both lines */
    for (uint8_t left = RECOVERY_CLOCKS; left != 0U; left--) {
        if ((TWI_PIN & _BV(TWI_SDA)) != 0U) { break; }
        scl_low();
        scl_release();
    }
    scl_low();
    TWI_PORT &= (uint8_t)~_BV(TWI_SDA);
    TWI_DDR |= _BV(TWI_SDA);
    scl_release();
    TWI_DDR &= (uint8_t)~_BV(TWI_SDA); /* SDA rises while SCL is high: STOP */
    TWI_PORT |= _BV(TWI_SDA);
    if (twi_recoveries != UINT8_MAX) { twi_recoveries++; }
}

void twi_init(void)
{
    TWI_PORT |= _BV(TWI_SDA) | _BV(TWI_SCL);
    TWBR = BIT_RATE;
}

bool twi_begin(uint8_t address, uint8_t *buffer, uint8_t write_len, uint8_t read_len,
               uint32_t now_us)
{
    bus_t *const  it   = PORT_REACH(&bus);
    const uint8_t sreg = SREG;

    cli(); /* of two that come here only one may find it free */
    const bool is_busy = it->state == TWI_BUSY;
    it->state          = TWI_BUSY;
    SREG               = sreg;
    if (is_busy) { return false; }
    it->sla        = (uint8_t)(address << 1);
    it->first      = buffer;
    it->next       = buffer;
    it->write_left = write_len;
    it->read_left  = read_len;
    it->begun_us   = (uint16_t)now_us;
    /* After the STOP under way, if one is. */
    TWCR = (uint8_t)((TWCR & _BV(TWSTO)) | GO | _BV(TWSTA));
    return true;
}

twi_status_t twi_poll(uint32_t now_us)
{
    bus_t *const it = PORT_REACH(&bus);

    if (it->state == TWI_BUSY) { /* and stays so for whoever would begin: begun_us holds still */
        const uint16_t late_us = (uint16_t)((uint16_t)now_us - it->begun_us - TIMEOUT_US);
        /* What an interrupt has begun since the caller looked at the clock is not late. */
        if (late_us < 60000U) {
            recover();
            it->state = TWI_FAILED;
        }
    }
    return it->state;
}
