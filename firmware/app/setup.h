/* SPDX-License-Identifier: MIT */
/* setup - the settings in force: from EEPROM at the start, changed by key, checked as a whole.
 *
 * Model     one copy, in which the modules' configurations lie; what changes it tells them
 * Formats   keys, ranges and factory values: shared_c/spec/settings.toml    results: messages.toml
 * Bad data  a value that its range or another setting refuses is not taken. A record that is whole
 *           but contradicts itself gives the factory's values, and the fault settings_lost
 * Context   main loop
 */
#ifndef SETUP_H
#define SETUP_H

#include "settings_table.h"

#include <stdint.h>

extern settings_t setup;

/* Load them, and set up the chains by them (weighing_setup, attitude_setup). */
void setup_init(void);

/* MESSAGES_RESULT_...; if refused, nothing changes. */
uint8_t setup_get(uint8_t key, int32_t *value);
uint8_t setup_set(uint8_t key, int32_t value);

/* Factory settings, in force and saved; the calibration too where `what` says so. */
void setup_reset(uint8_t what);

/* Write all to EEPROM, in the background. */
void setup_save(void);

#endif
