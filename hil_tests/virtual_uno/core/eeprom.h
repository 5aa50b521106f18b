/* SPDX-License-Identifier: GPL-3.0-or-later */
/* eeprom - the 1 KiB data EEPROM, as in the ATmega328P datasheet, section 8.4.
 *
 * Model     EEMPE opens a window of 4 cycles for EEPE; programming then takes 3.4 ms (erase and
 *           write) or 1.8 ms (one of them), during which EEPE stays set and writes are ignored
 * Bad data  power lost in mid-write leaves the cell erased (0xFF); any other reset lets the
 *           write complete
 */
#ifndef EEPROM_H
#define EEPROM_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/avr_eeprom.h>

struct uno;

typedef struct {
    avr_eeprom_t *simavr; /* lends its cells and its vector */
    bool          busy;
    uint16_t      addr;  /* of the write under way */
    uint8_t       value; /* what its cell will hold */
} eeprom_t;

void eeprom_init(struct uno *uno);
void eeprom_before_reset(struct uno *uno, bool power_lost);
void eeprom_after_reset(struct uno *uno);

#endif
