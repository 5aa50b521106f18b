/* SPDX-License-Identifier: MIT */
/* eeprom - the chip's own 1 KiB of EEPROM, one cell at a time, while the main loop goes on.
 *
 * Model     a write takes 3.4 ms where a cell is erased and written, 1.8 ms where it is one of both
 *           (ATmega328P datasheet, 8.4 and table 8-1)
 * Bad data  none: who writes reads back. Addresses wrap at 1024
 * Context   main loop. Interrupts are held back for 8 cycles.
 */
#ifndef EEPROM_H
#define EEPROM_H

#include <stdbool.h>
#include <stdint.h>

/* A write is under way. */
bool eeprom_is_busy(void);

/* Read a cell; waits for a write that is under way, 3.4 ms at most. */
uint8_t eeprom_read(uint16_t address);

/* What a write does; the bits of EECR. */
enum {
    EEPROM_REPLACE = 0x00,
    EEPROM_ERASE   = 0x10, /* to 0xFF, whatever the value */
    EEPROM_PROGRAM = 0x20  /* of an erased cell: half of the wear was its erasing */
};

/* Begin to write a cell; only while not busy. */
void eeprom_write(uint16_t address, uint8_t value, uint8_t how);

#endif
