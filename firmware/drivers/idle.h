/* SPDX-License-Identifier: MIT */
/* idle - sleep until an interrupt has work for the main loop, and how long that was.
 *
 * Model     the main loop calls idle_clear_work, does all the work there is, then idle_sleep. An
 *           interrupt that posts work in between makes idle_sleep return at once; the flag is
 *           looked at with interrupts off, and `sei; sleep` lets no interrupt in between
 *           (ATmega328P datasheet, 7.7.1), so that no wake-up is lost.
 * Formats   slept time: ticks of 0.5 us; what an interrupt does while the main loop sleeps counts
 *           as busy, but for its entry and pushes
 * Context   main loop, except the inline functions for interrupts. Interrupts are held back for
 *           at most 40 cycles.
 */
#ifndef IDLE_H
#define IDLE_H

#include "uno_pins.h"

#include <avr/io.h>
#include <stdint.h>

/* Last of all drivers' inits but hx711's: enables interrupts. */
void idle_init(void);

static inline void idle_clear_work(void)
{
    IDLE_FLAGS &= (uint8_t)~_BV(IDLE_WORK_BIT);
}

void idle_sleep(void);

/* Time asleep since the last call, in ticks of 0.5 us. */
uint32_t idle_take_slept_ticks(void);

/* First statement of every interrupt handler (after a time stamp, if it takes one). Called so that
 * a handler has to keep no more registers for it than it spoils. */
static inline __attribute__((always_inline)) void idle_interrupted(void)
{
    __asm__ volatile("%~call idle_note_waking" ::: "r24", "r25", "memory");
}

/* For an interrupt handler: do not go back to sleep. */
static inline __attribute__((always_inline)) void idle_post_work(void)
{
    IDLE_FLAGS |= _BV(IDLE_WORK_BIT);
}

#endif
