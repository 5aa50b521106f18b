/* SPDX-License-Identifier: GPL-3.0-or-later */
/* probe - what functions, interrupt handlers and critical sections cost in the running program.
 *
 * Model     while on, the core steps one instruction at a time and the probe follows calls,
 *           returns, interrupt entries, RETI, the I flag and the stack pointer
 * Counted   function: from the first cycle of the instruction that enters it (CALL 4, RCALL 3,
 *           ICALL 3, or a tail call's jump) to the last of its RET; interrupts are taken out.
 *           handler: entry 4, jump in the vector table, body, RETI; nested handlers are taken
 *           out, and so are the 4 extra cycles of waking.
 *           window: I clear outside handlers, from the end of the instruction that cleared it
 *           to the end of the one that set it; I clear since reset is start-up, no window
 * Bad data  frames that a longjmp() skips are dropped; calls nested deeper than PROBE_DEPTH
 *           are not counted
 */
#ifndef PROBE_H
#define PROBE_H

#include <stdbool.h>
#include <stdint.h>

#include "uno.h"

enum { PROBE_DEPTH = 64, PROBE_FLASH_WORDS = 0x4000 };

typedef struct {
    bool     handler;  /* else a function */
    uint8_t  index;    /* vector, or function */
    uint16_t sp_after; /* stack pointer when it will have returned */
    uint64_t start;
    uint64_t stolen; /* cycles of handlers within it */
} probe_frame_t;

typedef struct {
    bool           on;
    uint8_t        function_at[PROBE_FLASH_WORDS]; /* by word address: index + 1, 0 = none */
    uno_function_t functions[UNO_FUNCTIONS_MAX];
    uint32_t       function_count;
    uno_vector_t   vectors[UNO_VECTORS];
    uno_window_t   windows[UNO_WINDOWS_MAX];
    uint32_t       window_count;
    uint64_t       windows_dropped;

    probe_frame_t frames[PROBE_DEPTH];
    uint32_t      depth;
    uint32_t      handlers; /* of the frames */

    bool     ran;         /* this step executes an instruction */
    bool     was_enabled; /* I before it */
    uint32_t pc;
    uint64_t began; /* its first cycle */

    bool     window_open;
    uint32_t window_pc;
    uint64_t window_began;

    uint16_t sp_min;
    uint64_t started, sleep_at_start; /* cycle counts when profiling began */
    uint64_t cycles, sleep_cycles;    /* filled when it stops */
} probe_t;

void probe_before(struct uno *uno);
void probe_after(struct uno *uno);
void probe_interrupt(struct uno *uno, uint8_t vector, uint64_t cost);
void probe_after_reset(struct uno *uno);

#endif
