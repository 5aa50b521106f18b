/* SPDX-License-Identifier: GPL-3.0-or-later */
/* uno_internal - what the parts of the simulated board share with one another.
 *
 * Every part keeps its state in its own struct inside uno_t, so that instances are independent;
 * there are no file-scope variables anywhere in this core.
 */
#ifndef UNO_INTERNAL_H
#define UNO_INTERNAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <simavr/sim_avr.h>
#include <simavr/sim_io.h>

#include "eeprom.h"
#include "hx711.h"
#include "parts.h"
#include "pins.h"
#include "probe.h"
#include "timing.h"
#include "twi.h"
#include "uno.h"
#include "usart.h"
#include "vcd.h"

enum { CORE_RUN_LIMIT_CYCLES = 1600 }; /* simavr looks at its timers at least this often */

struct uno {
    avr_t      *avr;
    uint64_t    reset_cycle; /* when the program last started */
    uint64_t    scramble;    /* generator for SRAM contents at power-on */
    uno_stats_t stats;
    pins_t      pins;
    timing_t    timing;
    usart_t     usart;
    twi_t       twi;
    eeprom_t    eeprom;
    hx711_t    *hx711;
    parts_t     parts;
    void       *source_ctx; /* Python's handle */
    probe_t     probe;
    vcd_t       vcd;
};

/* Gives `n` signal values for the instants `ticks`; defined by the cffi module. */
void uno_source(void *source_ctx, const uint64_t *ticks, double *counts, uint32_t n);

/* The same for a part on the two-wire bus: n rows of what it senses. */
void uno_part_source(void *source_ctx, uint8_t part, const uint64_t *ticks, uint8_t filter,
                     double *rows, uint32_t n);

/* First io module of that kind, and for ports of that name; never NULL on this chip. */
avr_io_t *core_find_io(avr_t *avr, const char *kind, char name);

/* Puts our handlers in place of simavr's; either may be NULL for plain memory. */
void core_hook(uno_t *uno, uint16_t addr, avr_io_read_t read, avr_io_write_t write);

/* What the running instruction itself writes into a register whose ones act: `v`, but of SBI and
 * CBI, which simavr makes a read and a write of the whole register, the one bit or nothing. */
uint8_t core_ones_written(const avr_t *avr, uint8_t v);

/* Cycles from now until the port write of the running instruction shows at the pin. */
uint8_t core_write_latency(const avr_t *avr);

#endif
