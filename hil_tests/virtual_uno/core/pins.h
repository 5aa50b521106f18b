/* SPDX-License-Identifier: GPL-3.0-or-later */
/* pins - port D as seen from outside the chip.
 *
 * simavr forces an input pin to its pull-up at every write to PORT, which makes false edges for
 * INT0. Here each pin that a part drives is declared to simavr as an external pull to the level
 * driven, so that a PORT write changes nothing.
 * SBI on a PIN register toggles its one bit only; simavr toggles all that read 1.
 */
#ifndef PINS_H
#define PINS_H

#include <stdint.h>

#include <simavr/avr_ioport.h>

struct uno;

enum { PINS_PORTS = 3 }; /* B, C, D */

typedef struct {
    avr_ioport_t  *port_d;
    avr_irq_t     *irq_d;              /* the port's pin signals */
    uint8_t        driven;             /* mask: pins that a part drives */
    uint8_t        level;              /* their levels */
    avr_io_write_t toggle[PINS_PORTS]; /* simavr's own PINx writers ... */
    void          *toggle_param[PINS_PORTS];
    uint8_t        floating; /* mask: pins with nothing attached; the pull-up decides */
} pins_t;

void pins_init(struct uno *uno);
void pins_after_reset(struct uno *uno);
void pins_drive(struct uno *uno, uint8_t bit, uint8_t level);
void pins_float(struct uno *uno, uint8_t bit);

#endif
