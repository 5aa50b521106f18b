/* SPDX-License-Identifier: MIT */
/* store - settings from EEPROM at the start, and back in the background.
 *
 * Model     settings.h tells what stands where, and which cell is written next; here are the cells
 * Bad data  a cell that will not take its value: another slot; without one, failed, and the newest
 *           record stays as it is
 * Context   main loop.  Cost: firmware/budget.toml
 */
#ifndef STORE_H
#define STORE_H

#include "settings.h"

#include <stdint.h>

/* The newest record into `settings`, the factory's where there is none. SETTINGS_WHOLE: it was
 * found. SETTINGS_NO_RECORD: none was ever saved. SETTINGS_FOREIGN: the newest is of another
 * firmware, and the factory's values hold. SETTINGS_ROTTEN: a bit has changed in a record that may
 * have been the newest; another holds, or the factory's values. */
settings_reading_t store_load(settings_t *settings);

/* Save, or where a save is under way, take in what has changed since. Values that belong together
 * are saved together only if this is called after they changed. */
void store_save(void);

/* Go on with a save: to the next cell that must be written, by a few at most, 0.25 ms. Until
 * the save is done, the main loop does not sleep. `settings` are those to be saved. */
void store_tick(const settings_t *settings);

uint8_t  store_state(void);    /* MESSAGES_SETTINGS_STATE_... */
uint16_t store_sequence(void); /* of the newest record; 0: there is none */

#endif
