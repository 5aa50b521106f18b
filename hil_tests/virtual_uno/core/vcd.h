/* SPDX-License-Identifier: GPL-3.0-or-later */
/* vcd - waveforms of the board's lines as a Value Change Dump (IEEE 1364, section 18).
 *
 * Edges are collected in memory, because a serial byte's are known ahead of the others', and
 * are sorted and written when the recording stops.
 */
#ifndef VCD_H
#define VCD_H

#include <stdbool.h>
#include <stdint.h>

enum { VCD_SCK, VCD_DOUT, VCD_TX, VCD_RX, VCD_SIGNALS };

typedef struct {
    uint64_t cycle;
    uint32_t order; /* keeps edges of one cycle in the order in which they came */
    uint8_t  signal;
    uint8_t  level;
} vcd_edge_t;

typedef struct {
    bool        on;
    bool        out_of_memory;
    vcd_edge_t *edges;
    uint32_t    count, room;
} vcd_t;

void vcd_put(vcd_t *vcd, uint8_t signal, uint64_t cycle, uint8_t level);
void vcd_free(vcd_t *vcd);

#endif
