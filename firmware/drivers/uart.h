/* SPDX-License-Identifier: MIT */
/* uart - USART0 as two byte rings served by interrupts, 8N1.
 *
 * Model     115200 baud: UBRR 16 with U2X gives 117647, 2.1 % high, as every Uno's; 500000 and
 *           1000000 baud are exact (ATmega328P datasheet, table 20-6)
 * Sending   frames are made in the ring itself; who makes one asks for room, so that none is torn
 * Bad data  bytes lost in the USART (data overrun), lost because the ring is full, or received
 *           with a framing error are counted, the last ones kept out of the ring
 * Context   main loop.  Cost of the interrupts: firmware/budget.toml
 */
#ifndef UART_H
#define UART_H

#include <stdbool.h>
#include <stdint.h>

enum {
    UART_TX_LEN = 256, /* indices are uint8 and wrap by themselves; one place stays empty */
    UART_RX_LEN = 64   /* 5.5 ms of a saturated line at 115200 baud, 0.6 ms at 1000000 */
};

typedef enum { UART_115200, UART_500000, UART_1000000 } uart_baud_t;

void uart_init(uart_baud_t baud);

/* Take a received byte; false if there is none. */
bool uart_read(uint8_t *byte);

/* Bytes that could be queued now. */
uint8_t uart_write_room(void);

/* Queue a byte; lost if there is no room. */
void uart_put(uint8_t byte);

/* Queue more in place: write to uart_tx_ring from uart_begin() on, no more than there is room for,
 * then say where it ends. */
extern uint8_t uart_tx_ring[UART_TX_LEN]; /* main loop writes, interrupt reads what is queued */
uint8_t        uart_begin(void);
void           uart_end(uint8_t behind);

/* Bytes lost or broken on the way in since reset; stops at 65535. */
uint16_t uart_rx_overruns(void);

#endif
