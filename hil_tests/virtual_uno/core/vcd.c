/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "uno_internal.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

enum { FIRST_ROOM = 4096, UNITS_PER_CYCLE = 625 }; /* of 100 ps: 62.5 ns */

void vcd_put(vcd_t *vcd, uint8_t signal, uint64_t cycle, uint8_t level)
{
    if (!vcd->on || vcd->out_of_memory) { return; }
    if (vcd->count == vcd->room) {
        const uint32_t room  = vcd->room ? 2U * vcd->room : FIRST_ROOM;
        vcd_edge_t    *edges = realloc(vcd->edges, room * sizeof *edges);

        if (!edges) {
            vcd->out_of_memory = true;
            return;
        }
        vcd->edges = edges;
        vcd->room  = room;
    }
    vcd->edges[vcd->count] = (vcd_edge_t){
        .cycle = cycle, .order = vcd->count, .signal = signal, .level = level};
    vcd->count++;
}

void vcd_free(vcd_t *vcd)
{
    free(vcd->edges);
    *vcd = (vcd_t){0};
}

static int by_time(const void *a, const void *b)
{
    const vcd_edge_t *x = a, *y = b;

    if (x->cycle != y->cycle) { return x->cycle < y->cycle ? -1 : 1; }
    return x->order < y->order ? -1 : x->order > y->order;
}

int uno_vcd_start(uno_t *uno)
{
    vcd_free(&uno->vcd);
    uno->vcd.on = true;
    vcd_put(&uno->vcd, VCD_SCK, uno->avr->cycle, (uint8_t)uno->pins.irq_d[3].value & 1U);
    vcd_put(&uno->vcd, VCD_DOUT, uno->avr->cycle, (uno->pins.level >> 2) & 1U);
    vcd_put(&uno->vcd, VCD_TX, uno->avr->cycle, 1);
    vcd_put(&uno->vcd, VCD_RX, uno->avr->cycle, 1);
    return uno->vcd.out_of_memory ? ENOMEM : 0;
}

static void write_edges(FILE *file, const vcd_t *vcd)
{
    static const char names[VCD_SIGNALS][5] = {"SCK", "DOUT", "TX", "RX"};
    uint8_t           last[VCD_SIGNALS]     = {2, 2, 2, 2}; /* unknown */
    uint64_t          last_cycle            = UINT64_MAX;

    fprintf(file, "$timescale 100 ps $end\n$scope module uno $end\n");
    for (uint8_t i = 0; i < VCD_SIGNALS; i++) {
        fprintf(file, "$var wire 1 %c %s $end\n", '!' + i, names[i]);
    }
    fprintf(file, "$upscope $end\n$enddefinitions $end\n");
    for (uint32_t i = 0; i < vcd->count; i++) {
        const vcd_edge_t *edge = &vcd->edges[i];

        if (last[edge->signal] == edge->level) { continue; }
        if (edge->cycle != last_cycle) {
            fprintf(file, "#%" PRIu64 "\n", edge->cycle * UNITS_PER_CYCLE);
        }
        fprintf(file, "%c%c\n", '0' + edge->level, '!' + edge->signal);
        last[edge->signal] = edge->level;
        last_cycle         = edge->cycle;
    }
}

int uno_vcd_stop(uno_t *uno, const char *path)
{
    vcd_t *vcd    = &uno->vcd;
    int    result = vcd->out_of_memory ? ENOMEM : 0;
    FILE  *file   = fopen(path, "w");

    if (!file) {
        result = errno;
    } else {
        qsort(vcd->edges, vcd->count, sizeof *vcd->edges, by_time);
        write_edges(file, vcd);
        if (ferror(file)) { result = EIO; }
        if (fclose(file) != 0) { result = errno; }
    }
    vcd_free(vcd);
    return result;
}
