/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "usart.h"

#include <stdlib.h>
#include <string.h>

enum { QUEUE_FIRST_ROOM = 4096, FE = 0x10 };

/* --- queues --- */

bool usart_queue_put(usart_queue_t *q, uint8_t byte, uint64_t cycle, bool stamped)
{
    if (q->head == q->room) {
        const uint32_t room   = q->room ? 2U * q->room : QUEUE_FIRST_ROOM;
        uint8_t       *bytes  = realloc(q->bytes, room);
        uint64_t      *cycles = NULL;

        if (!bytes) { return false; }
        q->bytes = bytes;
        if (stamped) {
            cycles = realloc(q->cycles, room * sizeof *cycles);
            if (!cycles) { return false; }
            q->cycles = cycles;
        }
        q->room = room;
    }
    q->bytes[q->head] = byte;
    if (stamped) { q->cycles[q->head] = cycle; }
    q->head++;
    return true;
}

void usart_queue_rewind(usart_queue_t *q)
{
    if (q->tail == q->head) { q->tail = q->head = 0; }
}

void usart_queue_compact(usart_queue_t *q)
{
    if (q->tail < QUEUE_FIRST_ROOM || q->tail < q->room / 2U) { return; }
    memmove(q->bytes, q->bytes + q->tail, q->head - q->tail);
    q->head -= q->tail;
    q->tail = 0;
}

/* --- the wire --- */

uint8_t usart_wire_level(uint8_t byte, double bit, double at)
{
    const int32_t i = (int32_t)(at / bit);

    if (at < 0.0 || i >= USART_FRAME_BITS - 1) { return 1; } /* idle or stop bit */
    return i == 0 ? 0 : (uint8_t)((byte >> (i - 1)) & 1U);
}

uint32_t usart_wire_resample(uint8_t byte, double from, double to, uint8_t *bytes, uint8_t *errors)
{
    uint32_t n     = 0;
    double   start = 0.0;

    while (n < USART_RESAMPLED_MAX) {
        uint8_t got = 0;
        for (int32_t i = 0; i < 8; i++) {
            got |= (uint8_t)(usart_wire_level(byte, from, start + (i + 1.5) * to) << i);
        }
        bytes[n]  = got;
        errors[n] = usart_wire_level(byte, from, start + 9.5 * to) ? 0 : FE;
        n++;
        /* the next falling edge of this frame after the stop bit was sampled */
        int32_t edge = (int32_t)((start + 9.5 * to) / from) + 1;
        while (edge < USART_FRAME_BITS - 1 &&
               !(usart_wire_level(byte, from, (edge - 0.5) * from) == 1 &&
                 usart_wire_level(byte, from, (edge + 0.5) * from) == 0)) {
            edge++;
        }
        if (edge >= USART_FRAME_BITS - 1) { break; }
        start = edge * from;
    }
    return n;
}
