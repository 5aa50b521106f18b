/* SPDX-License-Identifier: GPL-3.0-or-later */
/* timing - what interrupts cost and how their flags behave on the chip.
 *
 * Put right here, against simavr 1.6 (ATmega328P datasheet, sections 7.7 and 10..13):
 * - entry takes 4 cycles, 4 more out of sleep;
 * - one instruction runs after SEI and RETI before an interrupt, not two;
 * - TIFRn, EIFR and PCIFR are cleared by writing ones, bit by bit;
 * - enabling an interrupt whose flag is already set raises it;
 * - level-triggered INT0/INT1 are not polled every cycle (a great cost for a mode unused here).
 */
#ifndef TIMING_H
#define TIMING_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/sim_avr.h>

struct uno;

enum { TIMING_ENTRY_CYCLES = 4, TIMING_WAKE_CYCLES = 4 };

typedef struct {
    bool asleep; /* the last step slept: the next interrupt entry takes longer */
} timing_t;

void timing_init(struct uno *uno);
void timing_free(struct uno *uno);
void timing_after_reset(struct uno *uno);
void timing_after_service(struct uno *uno);

#endif
