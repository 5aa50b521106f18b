/* SPDX-License-Identifier: GPL-3.0-or-later */
/* EEPROM programming; PD3 is high while a write is under way, results are for the test to peek. */
#include <avr/interrupt.h>
#include <avr/io.h>

volatile uint8_t reset_flags, read_back, erased, written_only, late_master, ready_count, done;

ISR(EE_READY_vect)
{
    ready_count++;
    EECR &= (uint8_t)~_BV(EERIE);
}

static void write(uint8_t addr, uint8_t value, uint8_t mode)
{
    EECR = mode;
    EEAR = addr;
    EEDR = value;
    PORTD |= _BV(PD3);
    __asm__ volatile("sbi %0, %1\n\tsbi %0, %2" : : "I"(_SFR_IO_ADDR(EECR)), "I"(EEMPE), "I"(EEPE));
}

static void wait(void)
{
    while (EECR & _BV(EEPE)) {}
    PORTD &= (uint8_t)~_BV(PD3);
}

static uint8_t read(uint8_t addr)
{
    EEAR = addr;
    EECR |= _BV(EERE);
    return EEDR;
}

int main(void)
{
    reset_flags = MCUSR;
    DDRD |= _BV(PD3);
    write(0x10, 0x5A, 0);
    EEAR = 0x11; /* while busy: refused */
    EEDR = 0x77;
    __asm__ volatile("sbi %0, %1\n\tsbi %0, %2" : : "I"(_SFR_IO_ADDR(EECR)), "I"(EEMPE), "I"(EEPE));
    wait();
    read_back = read(0x10);
    write(0x10, 0x00, _BV(EEPM0)); /* erase only */
    wait();
    erased = read(0x10);
    write(0x10, 0x0F, _BV(EEPM1)); /* write only: ones stay as they are */
    wait();
    write(0x10, 0xF3, _BV(EEPM1));
    wait();
    written_only = read(0x10);
    EEAR         = 0x12;
    EEDR         = 0x99;
    __asm__ volatile("sbi %0, %1\n\tnop\n\tnop\n\tnop\n\tnop\n\tsbi %0, %2"
                     :
                     : "I"(_SFR_IO_ADDR(EECR)), "I"(EEMPE), "I"(EEPE));
    late_master = EECR & _BV(EEPE);
    EECR |= _BV(EERIE); /* nothing under way: fires at once, and again after a write */
    sei();
    __asm__ volatile("nop\n\tnop");
    cli();
    done = 1;
    write(0x20, 0xAB, 0); /* the test resets the chip within this one */
    EECR |= _BV(EERIE);
    sei();
    wait();
    done = 2;
    for (;;) {}
}
