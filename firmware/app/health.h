/* SPDX-License-Identifier: MIT */
/* health - which faults hold, from whoever finds them: the bits of fault_flag in messages.toml.
 *
 * Context   main loop
 */
#ifndef HEALTH_H
#define HEALTH_H

#include <stdbool.h>
#include <stdint.h>

/* Of the faults in `mask`, those in `faults` hold from now on, the others do not. */
void health_note(uint16_t mask, uint16_t faults);

/* The same of one fault. */
void health_note_one(uint16_t fault, bool holds);

uint16_t health_faults(void); /* now */
uint16_t health_seen(void);   /* since reset */

/* Those that have come or gone since this was asked last. */
uint16_t health_take_changed(void);

#endif
