/* SPDX-License-Identifier: MIT */
#include "twi.h"

#include "idle.h"
#include "port_reach.h"
#include "uno_pins.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stddef.h>
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
    TIMEOUT         = 3, /* of 1.024 ms: 16 bytes take 0.4 ms, and interrupts hold each back */
    GO              = _BV(TWINT) | _BV(TWEN) | _BV(TWIE),
    STOP            = _BV(TWINT) | _BV(TWEN) | _BV(TWSTO)
};

#define HALF_CLOCK_US 2.5

uint8_t twi_recoveries;

typedef struct {
    volatile uint8_t end;     /* twi_status_t of the last transfer; the interrupt writes */
    uint8_t         *next;    /* of the buffer; the interrupt's while busy, as TWI_LEFT is */
    uint8_t          sla;     /* address and direction */
    uint8_t          reg;     /* where the part is to begin */
    uint8_t          since;   /* when it was first seen under way, 1.024 ms */
    bool             is_seen; /* it was */
} bus_t;

static bus_t bus;

/* Runs 19 times in a burst of 14 bytes, 14 of them along `got`. */
ISR(TWI_vect, ISR_NAKED)
{
    __asm__ volatile(
        "push r24\n\t"
        "in r24, __SREG__\n\t"
        "push r24\n\t"
        "push r25\n\t"
        "push r30\n\t"
        "push r31\n\t"
        "sbic %[flags], %[asleep]\n\t" /* idle_interrupted, but for the call where awake */
        "%~call idle_note_waking\n\t"
        "lds r30, %[next]\n\t"
        "lds r31, %[next] + 1\n\t"
        "lds r25, %[twsr]\n\t"
        "ldi r24, %[go]\n\t"
        "cpi r25, %[got_more]\n\t"
        "breq 1f\n\t"
        "cpi r25, %[got_last]\n\t"
        "breq 1f\n\t"
        "cpi r25, %[read_acked]\n\t"
        "breq 2f\n\t"
        "cpi r25, %[sent_acked]\n\t"
        "breq 5f\n\t"
        "lds r24, %[reg]\n\t"
        "cpi r25, %[write_acked]\n\t"
        "breq 7f\n\t"
        "lds r24, %[sla]\n\t"
        "cpi r25, %[restart]\n\t"
        "breq 7f\n\t"
        "andi r24, 0xFE\n\t"
        "cpi r25, %[start]\n\t"
        "breq 7f\n\t"
        "ldi r24, %[refused]\n\t" /* not acknowledged; bus error, arbitration lost */
        "rjmp 9f\n"
        "1:\n\t" /* a byte has come */
        "lds r24, %[twdr]\n\t"
        "st Z+, r24\n\t"
        "cpi r25, %[got_last]\n\t"
        "breq 8f\n"
        "3:\n\t"
        "sts %[next] + 1, r31\n\t"
        "sts %[next], r30\n\t"
        "ldi r24, %[go]\n"
        "2:\n\t" /* the next one is acknowledged unless it is the last; sent, none is */
        "in r25, %[left]\n\t"
        "dec r25\n\t"
        "out %[left], r25\n\t"
        "breq 4f\n\t"
        "ori r24, %[acknowledge]\n"
        "4:\n\t"
        "sts %[twcr], r24\n"
        ".global twi_leave\n" /* other handlers that have kept the same end here */
        "twi_leave:\n\t"
        "pop r31\n\t"
        "pop r30\n\t"
        "pop r25\n\t"
        "pop r24\n\t"
        "out __SREG__, r24\n\t"
        "pop r24\n\t"
        "reti\n"
        "5:\n\t" /* the register, or a byte behind it, was sent */
        "lds r25, %[sla]\n\t"
        "ori r24, %[again]\n\t"
        "sbrc r25, 0\n\t"
        "rjmp 4b\n\t"
        "in r25, %[left]\n\t"
        "tst r25\n\t"
        "breq 8f\n\t"
        "ld r24, Z+\n\t"
        "sts %[twdr], r24\n\t"
        "rjmp 3b\n"
        "7:\n\t"
        "sts %[twdr], r24\n\t"
        "ldi r24, %[go]\n\t"
        "rjmp 4b\n"
        "8:\n\t"
        "ldi r24, %[idle]\n"
        "9:\n\t"
        "sts %[end], r24\n\t"
        "cbi %[flags], %[busy]\n\t"
        "sbi %[flags], %[work]\n\t"
        "ldi r24, %[stop]\n\t"
        "rjmp 4b" ::[next] "i"(&bus.next),
        [sla] "i"(&bus.sla), [reg] "i"(&bus.reg), [end] "i"(&bus.end), [busy] "I"(TWI_BUSY_BIT),
        [twsr] "n"(_SFR_MEM_ADDR(TWSR)), [twdr] "n"(_SFR_MEM_ADDR(TWDR)),
        [twcr] "n"(_SFR_MEM_ADDR(TWCR)), [left] "I"(_SFR_IO_ADDR(TWI_LEFT)),
        [flags] "I"(_SFR_IO_ADDR(IDLE_FLAGS)), [work] "I"(IDLE_WORK_BIT),
        [asleep] "I"(IDLE_ASLEEP_BIT), [go] "n"(GO), [again] "n"(_BV(TWSTA)),
        [acknowledge] "n"(_BV(TWEA)), [stop] "n"(STOP), [got_more] "n"(GOT_MORE),
        [got_last] "n"(GOT_LAST), [read_acked] "n"(READ_ACKED), [sent_acked] "n"(SENT_ACKED),
        [write_acked] "n"(WRITE_ACKED), [restart] "n"(RESTART), [start] "n"(START),
        [idle] "n"(TWI_IDLE), [refused] "n"(TWI_REFUSED)
        : "memory");
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

void twi_ready(uint8_t sla, uint8_t reg, uint8_t *buffer, uint8_t len)
{
    bus_t *const it = PORT_REACH(&bus);

    it->sla  = sla;
    it->reg  = reg;
    it->next = buffer;
    TWI_LEFT = len;
}

void twi_go(void)
{
    IDLE_FLAGS |= _BV(TWI_BUSY_BIT);
    /* After the STOP under way, if one is. */
    TWCR = (uint8_t)((TWCR & _BV(TWSTO)) | GO | _BV(TWSTA));
}

twi_status_t twi_poll(uint8_t now)
{
    bus_t *const it = PORT_REACH(&bus);

    if ((IDLE_FLAGS & _BV(TWI_BUSY_BIT)) == 0U) {
        it->is_seen = false;
        return it->end;
    }
    if (!it->is_seen) {
        it->is_seen = true;
        it->since   = now;
    } else if ((uint8_t)(now - it->since) >= TIMEOUT) {
        recover();
        IDLE_FLAGS &= (uint8_t)~_BV(TWI_BUSY_BIT);
        it->is_seen = false;
        return TWI_FAILED;
    }
    return TWI_BUSY;
}
