/* SPDX-License-Identifier: GPL-3.0-or-later */
/* usart - USART0, asynchronous 8N1, as in the ATmega328P datasheet, section 20.
 *
 * Model     a byte takes 10 bit times in each direction; transmit: buffer and shift register;
 *           receive: two-byte buffer and shift register, DOR when a start bit finds all full,
 *           FE kept with its byte
 * Baud      the two ends may differ: each end samples the other's waveform at its own bit times,
 *           so a mismatch garbles bytes and misses stop bits as on a wire
 * Bad data  other frame formats (parity, 5..7 or 9 bits, synchronous) behave as 8N1
 */
#ifndef USART_H
#define USART_H

#include <stdbool.h>
#include <stdint.h>

#include <simavr/avr_uart.h>

struct uno;

enum {
    USART_FRAME_BITS    = 10,
    USART_RESAMPLED_MAX = 16 /* bytes that a fast receiver can make of one slow byte */
};

typedef struct {
    uint8_t  *bytes;
    uint64_t *cycles; /* NULL where no stamps are kept */
    uint32_t  head, tail, room;
} usart_queue_t;

typedef struct {
    avr_uart_t   *simavr; /* lends its three vectors */
    double        host_baud;
    uint8_t       tx_buffer, tx_shift;
    bool          tx_buffer_full, tx_shifting;
    uint8_t       rx_data[2], rx_error[2]; /* the buffer; error: FE bit */
    uint8_t       rx_count;                /* bytes in the buffer, 0..2 */
    uint8_t       rx_shift, rx_shift_error;
    bool          rx_shift_full;
    bool          rx_lost;   /* DOR */
    bool          line_busy; /* the host is sending */
    usart_queue_t to_device;
    usart_queue_t to_host;
} usart_t;

void usart_init(struct uno *uno);
void usart_free(usart_t *usart);
void usart_after_reset(struct uno *uno);

/* --- usart_wire.c: queues and the waveform --- */

/* False when out of memory: the byte is lost. */
bool usart_queue_put(usart_queue_t *q, uint8_t byte, uint64_t cycle, bool stamped);
void usart_queue_rewind(usart_queue_t *q);
/* A sender that never lets the queue run empty must not make it grow without end. */
void usart_queue_compact(usart_queue_t *q);

/* Level of a frame of `byte` sent with bit time `bit`, at time `at`; idle high outside. */
uint8_t usart_wire_level(uint8_t byte, double bit, double at);

/* What a receiver with bit time `to` makes of one frame sent with bit time `from`: at most
 * USART_RESAMPLED_MAX bytes, each with 0 or the FE bit of UCSR0A; returns how many. Sampling
 * starts at each falling edge that finds the receiver idle. */
uint32_t usart_wire_resample(uint8_t byte, double from, double to, uint8_t *bytes, uint8_t *errors);

#endif
