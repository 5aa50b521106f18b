/* SPDX-License-Identifier: MIT */
#include "eeprom.h"

#include <avr/interrupt.h>
#include <avr/io.h>

_Static_assert(EEPROM_ERASE == _BV(EEPM0) && EEPROM_PROGRAM == _BV(EEPM1), "bits of EECR");

bool eeprom_is_busy(void)
{
    return (EECR & _BV(EEPE)) != 0U;
}

uint8_t eeprom_read(uint16_t address)
{
    while (eeprom_is_busy()) {}
    EEAR = address;
    EECR |= _BV(EERE);
    return EEDR;
}

void eeprom_write(uint16_t address, uint8_t value, uint8_t how)
{
    const uint8_t sreg = SREG;

    EEAR = address;
    EEDR = value;
    EECR = how;
    cli();
    EECR |= _BV(EEMPE); /* one SBI each: EEPE follows within 2 of the 4 cycles */
    EECR |= _BV(EEPE);
    SREG = sreg;
}
